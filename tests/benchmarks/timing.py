"""Where time goes, function by function."""

import time


def timed(function, step, spent, running):
    """A function that books its time, less that of other timed ones within it, under a step."""

    def run(*arguments, **named):
        start = time.process_time()
        running.append(0.0)
        result = function(*arguments, **named)
        taken = time.process_time() - start
        spent[step] += taken - running.pop()
        if running:
            running[-1] += taken
        return result

    return run
