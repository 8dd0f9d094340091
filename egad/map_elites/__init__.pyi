from .archive import Archive as Archive
from .archive import Elite as Elite
from .archive import elites_of as elites_of
from .archive import merge as merge
from .island import Watch as Watch
from .island import evolve as evolve
from .parameters import Evolution as Evolution
from .parameters import EvolutionParameters as EvolutionParameters
