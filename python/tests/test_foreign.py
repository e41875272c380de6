"""Objects of pyuff, SDynPy and sdypy-EMA: the real ones where they are installed, and ones that have what those have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import retune

SHAPES = np.array([[1.0, 0.4], [0.5, -1.0], [0.2, 0.7]])


def dataset(frequency: float, column: int, **more: Any) -> dict[str, Any]:
    """Dataset 55 of a normal mode: three values a node, zero where nothing was measured."""
    return {
        "type": 55,
        "analysis_type": 2,
        "freq": frequency,
        "modal_damp_vis": 0.01 * (column + 1),
        "node_nums": np.array([7, 8, 9]),
        "r1": np.zeros(3),
        "r2": np.zeros(3),
        "r3": SHAPES[:, column],
        **more,
    }


def test_modes_of_dictionaries() -> None:
    places = {"type": 15, "node_nums": [7, 8, 9], "x": [0.0, 0.1, 0.2], "y": [0.0] * 3, "z": [1.0] * 3}
    # The second comes first in the file.
    test = retune.Test.from_uff([places, dataset(31.0, 1), dataset(10.0, 0)], frequency_sd=0.05, shape_sd=0.02, name="hammer")
    assert np.array_equal(test.frequencies, [10.0, 31.0]) and test.damping == pytest.approx([0.01, 0.02])
    assert np.array_equal(test.shapes, SHAPES)
    assert [(s.name, s.node, s.position) for s in test.sensors] == [
        ("7.+z", "7", (0.0, 0.0, 1.0)),
        ("8.+z", "8", (0.1, 0.0, 1.0)),
        ("9.+z", "9", (0.2, 0.0, 1.0)),
    ]
    named = retune.Test.from_uff([dataset(10.0, 0)], nodes={7: "root", 8: "middle", 9: "tip"}, frequency_sd=0.05, shape_sd=0.02)
    assert [s.node for s in named.sensors] == ["root", "middle", "tip"]
    pole = 2 * np.pi * 10.0 * (-0.02 + 1j * np.sqrt(1 - 0.02**2))
    complex_mode = dataset(0.0, 0, analysis_type=3, eig=pole, r3=SHAPES[:, 0] + 0.1j)
    test = retune.Test.from_uff(complex_mode, frequency_sd=0.05, shape_sd=0.02)
    assert test.frequencies == pytest.approx([10.0]) and test.damping == pytest.approx([0.02])
    assert np.array_equal(test.shapes[:, 0], SHAPES[:, 0] + 0.1j)


def test_what_is_no_mode_is_refused() -> None:
    with pytest.raises(ValueError, match="no modes among these"):
        retune.Test.from_uff([{"type": 58}])
    with pytest.raises(ValueError, match="no name for point 8"):
        retune.Test.from_uff([dataset(10.0, 0)], nodes={7: "a"})
    with pytest.raises(ValueError, match="no dataset 58"):
        retune.Frfs.from_uff([{"type": 55}])
    turning = {"type": 58, "x": [1.0, 2.0], "data": [1j, 1j], "rsp_node": 1, "rsp_direct": 4, "ref_node": 1, "ref_direct": 3}
    with pytest.raises(ValueError, match="a rotation"):
        retune.Frfs.from_uff([turning])


def test_the_files_of_pyuff(tmp_path: Path) -> None:
    """What pyuff reads of a file that it wrote, and what the reader of retune reads of it, are one."""
    pyuff = pytest.importorskip("pyuff", reason="skipped: `pyuff` is not here")
    file = tmp_path / "modes.unv"
    out = pyuff.UFF(str(file))
    for k, frequency in enumerate((10.0, 31.0)):
        entry = pyuff.prepare_55(
            id1="NONE", id2="NONE", id3="NONE", id4="NONE", id5="NONE", model_type=1, analysis_type=2, data_ch=2, spec_data_type=8,
            data_type=2, n_data_per_node=3, r1=np.zeros(3), r2=np.zeros(3), r3=SHAPES[:, k], load_case=1, mode_n=k + 1, freq=frequency,
            modal_m=1.0, modal_damp_vis=0.01, modal_damp_his=0.0, node_nums=np.array([7, 8, 9]),
        )  # fmt: skip
        out.write_sets(entry, "add" if k else "overwrite")
    read = pyuff.UFF(str(file)).read_sets()
    test = retune.Test.from_uff(read, frequency_sd=0.05, shape_sd=0.02)
    assert np.allclose(test.frequencies, [10.0, 31.0]) and np.allclose(test.shapes, SHAPES, atol=1e-5)
    ours = retune.identify(file, units="SI").test
    assert np.allclose(ours.frequencies, test.frequencies, rtol=1e-5)


def test_shapes_of_sdynpy() -> None:
    try:
        import sdynpy
    except Exception as e:  # it opens windows, and needs libraries of the system for them
        pytest.skip(f"skipped: `sdynpy` is not here: {e}")
    coordinate = sdynpy.coordinate_array([7, 8, 9], 3)
    shapes = sdynpy.shape_array(coordinate, SHAPES.T, np.array([10.0, 31.0]), np.array([0.01, 0.02]))
    test = retune.Test.from_sdynpy(shapes, frequency_sd=0.05, shape_sd=0.02)
    assert np.array_equal(test.shapes, SHAPES) and test.damping == pytest.approx([0.01, 0.02])
    assert [s.name for s in test.sensors] == ["7.+z", "8.+z", "9.+z"]
    f = np.linspace(1.0, 5.0, 9)
    h = np.random.default_rng(0).normal(size=(9, 3, 1)) + 1j
    both = sdynpy.coordinate.outer_product(coordinate, sdynpy.coordinate_array([7], 3))
    kind = sdynpy.data.FunctionTypes.FREQUENCY_RESPONSE_FUNCTION
    functions = sdynpy.data_array(kind, f, np.moveaxis(h, 0, -1), both)
    frfs = retune.Frfs.from_sdynpy(functions)
    assert np.array_equal(frfs.h, h) and [c.name for c in frfs.responses] == ["7", "8", "9"]


def test_shapes_that_have_what_those_of_sdynpy_have() -> None:
    dtype = [("frequency", float), ("damping", float), ("coordinate", [("node", int), ("direction", int)], (3,)), ("shape_matrix", float, (3,))]
    shapes = np.zeros(2, dtype=dtype)
    for k in range(2):
        shapes[k]["frequency"], shapes[k]["damping"] = (10.0, 31.0)[k], 0.01
        shapes[k]["coordinate"]["node"], shapes[k]["coordinate"]["direction"] = [7, 8, 9], [3, 3, -1]
        shapes[k]["shape_matrix"] = SHAPES[:, k]
    test = retune.Test.from_sdynpy(shapes, frequency_sd=0.05, shape_sd=0.02)
    assert np.array_equal(test.shapes, SHAPES)
    assert [(s.name, s.direction) for s in test.sensors][-1] == ("9.-x", (-1.0, 0.0, 0.0))


@pytest.mark.filterwarnings("ignore")
def test_a_model_of_sdypy(cantilever: retune.Model) -> None:
    """Its own identification of functions of the cantilever, and what retune makes of its results."""
    ema = pytest.importorskip("sdypy.EMA", reason="skipped: `sdypy-EMA` is not here")
    f = np.linspace(1.0, 300.0, 3000)
    frfs = cantilever.frf(f, "tip", ["middle", "tip"], damping=0.01, quantity="receptance")
    model = ema.Model(frf=frfs.h[:, :, 0].T, freq=f, lower=5, upper=290, pol_order_high=20, frf_form="receptance")
    model.get_poles(show_progress=False)
    # Its polynomials do not reach the first one, below a twentieth of the band.
    modes = cantilever.modes(n=3).frequencies[1:]
    model.select_closest_poles(list(modes))
    model.get_constants()
    test = retune.Test.from_sdypy(model, ["middle", "tip"], frequency_sd=0.01 * modes, shape_sd=0.02)
    assert test.frequencies == pytest.approx(modes, rel=2e-3) and test.damping == pytest.approx([0.01] * 2, rel=0.05)
    pairs = retune.compare(cantilever, test).pairs
    assert [p.model_mode for p in pairs] == [2, 3] and all(p.mac is not None and p.mac > 0.98 for p in pairs)
    back = retune.Frfs.from_sdypy(model, ["middle.+z", "tip.+z"], "tip.+z")
    assert back.quantity == "receptance" and back.h.shape[1:] == (2, 1)


def test_modes_of_functions(cantilever: retune.Model) -> None:
    f = np.linspace(1.0, 100.0, 1500)
    test = retune.Test.from_frfs(cantilever.frf(f, "tip", ["middle", "tip"], damping=0.01), health=False)
    assert test.frequencies == pytest.approx(cantilever.modes(n=2).frequencies, rel=1e-4)
