"""Files of weights, and errors about them as the detector tells them; needs the extra."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from egad.detectors import prepare_input
from egad.detectors.ggcnn import GGCNN
from egad.errors import UserError

torch = pytest.importorskip("torch")
safetensors = pytest.importorskip("safetensors.torch")
networks = pytest.importorskip("egad.detectors.networks")
weights = pytest.importorskip("egad.detectors.weights")
CONVOLUTIONS = torch.nn.Conv2d | torch.nn.ConvTranspose2d


def saved(path, state):
    if path.suffix == ".safetensors":
        safetensors.save_file(state, path)
    else:
        torch.save(state, path)
    return str(path)


@pytest.mark.parametrize(("name", "count"), [("ggcnn", 62_420), ("ggcnn2", 66_676)])
def test_networks_have_as_many_weights_as_the_published_ones(name, count):
    assert networks.parameters(networks.new_network(name, 0)) == count


@pytest.mark.parametrize("name", ["ggcnn", "ggcnn2"])
@pytest.mark.parametrize("ending", ["pt", "safetensors"])
def test_four_images_of_the_size_of_the_one_that_went_in(tmp_path, name, ending):
    network = networks.new_network(name, 1)
    path = tmp_path / f"weights.{ending}"
    if ending == "pt":
        torch.save(network.state_dict(), path)
    else:
        weights.write(network, path, {"network": name})
    infer = networks.inference(weights.read(path))
    depth = np.random.default_rng(0).normal(size=(300, 300)).astype(np.float32)
    answer = infer(depth)
    assert answer.shape == (4, 300, 300)
    np.testing.assert_array_equal(infer(depth), answer)
    np.testing.assert_array_equal(networks.inference(network)(depth), answer)


def test_one_convolution_for_all_heads_gives_what_four_give():
    network = networks.new_network("ggcnn2", 0)
    image = torch.randn(2, 1, 300, 300, generator=torch.Generator().manual_seed(0))
    with torch.inference_mode():
        inside = network.features(image)
        one_by_one = [getattr(network, name)(inside) for name in networks.OUTPUTS]
        torch.testing.assert_close(network(image), torch.cat(one_by_one, dim=1))


def test_untrained_weights_follow_from_the_seed_and_leave_chance_alone():
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    one, same, other = (networks.new_network("ggcnn", seed).state_dict() for seed in (0, 0, 1))
    torch.testing.assert_close(torch.rand(3), expected)
    assert all(torch.equal(one[name], same[name]) for name in one)
    assert not torch.equal(one["conv1.weight"], other["conv1.weight"])


@pytest.mark.parametrize("name", ["ggcnn", "ggcnn2"])
@pytest.mark.parametrize("seed", range(3))
def test_hardly_a_channel_of_an_untrained_network_is_dead(name, seed):
    """As many as half were, when biases outweighed depths that vary by centimetres."""
    random = np.random.default_rng(seed)
    depth = np.full((8, 300, 300), 0.6)
    depth[:, 100:200, 120:180] -= random.uniform(0.02, 0.08, (8, 1, 60))
    network = networks.new_network(name, seed)
    channels = []
    for layer in network.modules():
        if isinstance(layer, CONVOLUTIONS) and layer.out_channels > 1:
            layer.register_forward_hook(
                lambda _layer, _input, output: channels.append(output.amax(dim=(0, 2, 3)) > 0)
            )
    inputs = np.stack([prepare_input(each) for each in depth])
    with torch.inference_mode():
        answers = network(torch.from_numpy(inputs)[:, None])
    alive = [float(layer.double().mean()) for layer in channels]
    assert min(alive) >= 0.8, alive
    assert 0.01 < answers.std() < 0.5


def test_the_same_weights_give_the_same_bytes_and_keep_their_notes(tmp_path):
    network = networks.new_network("ggcnn", 0)
    paths = [tmp_path / f"{n}.safetensors" for n in range(2)]
    for path in paths:
        weights.write(network, path, {"seed": 0, "network": "ggcnn"})
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with safetensors.safe_open(paths[0], "pt") as file:
        assert json.loads(file.metadata()["egad"]) == {"network": "ggcnn", "seed": 0}


@pytest.mark.parametrize("ending", ["pt", "safetensors"])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"conv1.weight": (8, 1, 9, 9)}, "GG-CNN, but conv1.weight is 8 x 1 x 9 x 9, not 32 x 1"),
        ({"conv1.weight": None}, "GG-CNN, but conv1.weight is missing"),
        ({"conv9.weight": (1,)}, "GG-CNN, but conv9.weight is unexpected"),
        ({"features.0.weight": (16, 1, 3, 3)}, "GG-CNN2, but features.0.weight is 16 x 1 x 3 x 3"),
    ],
)
def test_weights_of_another_network_are_told_apart(tmp_path, change, words, ending):
    state = networks.new_network("ggcnn", 0).state_dict()
    for name, shape in change.items():
        state.pop(name, None)
        if shape:
            state[name] = torch.zeros(shape)
    path = saved(tmp_path / f"weights.{ending}", state)
    with pytest.raises(
        UserError, match=rf"not weights of GG-CNN or GG-CNN2.*{words}.*dougsm/ggcnn"
    ):
        GGCNN(path)


@pytest.mark.parametrize(
    ("value", "words"),
    [(torch.zeros(32, dtype=torch.float64), "float64, not"), (torch.full((32,), np.nan), "finite")],
)
def test_other_kinds_of_numbers_are_refused(tmp_path, value, words):
    state = {**networks.new_network("ggcnn", 0).state_dict(), "conv1.bias": value}
    with pytest.raises(UserError, match=rf"conv1\.bias .*{words}"):
        GGCNN(saved(tmp_path / "weights.safetensors", state))


@pytest.mark.parametrize("state", [[1, 2], {"conv1.weight": 3}])
def test_weights_of_something_else_are_a_mistake(tmp_path, state):
    with pytest.raises(UserError, match=r"is not a state dictionary: .*dougsm/ggcnn"):
        GGCNN(saved(tmp_path / "weights.pt", state))


def test_a_safetensors_file_must_hold_what_its_header_promises(tmp_path):
    path = tmp_path / "weights.safetensors"
    weights.write(networks.new_network("ggcnn", 0), path, {})
    whole = path.read_bytes()
    (size,) = struct.unpack("<Q", whole[:8])
    header = json.loads(whole[8 : 8 + size])
    header["conv1.bias"]["data_offsets"][1] = 1 << 50
    greedy = json.dumps(header).encode()
    for broken in (
        b"",
        whole[:5],
        whole[:100],
        whole[: 8 + size],
        whole[:-1],
        whole + b"more",
        struct.pack("<Q", 1 << 62) + whole[8:],
        struct.pack("<Q", len(greedy)) + greedy + whole[8 + size :],
        b"hello world, hello world",
    ):
        path.write_bytes(broken)
        with pytest.raises(UserError, match=r"not a complete safetensors file: .*dougsm/ggcnn"):
            GGCNN(str(path))


def test_what_is_no_file_of_weights_is_a_mistake(tmp_path):
    text = tmp_path / "weights.pt"
    text.write_text("hello")
    with pytest.raises(UserError, match=r"not a state dictionary.*dougsm/ggcnn"):
        GGCNN(str(text))
    with pytest.raises(UserError, match=r"no such file: .*dougsm/ggcnn"):
        GGCNN(str(tmp_path / "missing.pt"))


def test_code_hidden_in_weights_is_not_run(tmp_path):
    class Evil:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "owned",))

    with pytest.raises(UserError, match="not a state dictionary"):
        GGCNN(saved(tmp_path / "weights.pt", {"conv1.weight": Evil()}))
    assert not (tmp_path / "owned").exists()
