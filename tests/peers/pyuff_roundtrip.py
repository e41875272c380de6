"""Exchanges universal files with retune, for tests/uff_peer.rs.

    pyuff_roundtrip.py probe         says whether pyuff is there
    pyuff_roundtrip.py make DIR      writes files with pyuff, and what they hold as DIR/made.json
    pyuff_roundtrip.py check DIR     reads the files of DIR/written.json with pyuff and compares every value

A set is a dictionary with the keys of pyuff; complex arrays are {"re": [...], "im": [...]}.
Numbers are compared exactly: both sides know the same decimal digits or the same bits.
"""

import json
import os
import sys

import numpy as np
import pyuff


def plain(value):
    """A value of pyuff as JSON."""
    if isinstance(value, (np.ndarray, list, tuple)):
        array = np.asarray(value)
        if array.dtype.kind == "c":
            return {"re": array.real.tolist(), "im": array.imag.tolist()}
        return array.tolist()
    if isinstance(value, complex):
        return {"re": value.real, "im": value.imag}
    if isinstance(value, np.generic):
        return plain(value.item())
    return value


def flat(dataset):
    """Brings the sets of pyuff that are not flat into one form."""
    result = {str(k): plain(v) for k, v in dataset.items() if not isinstance(k, int)}
    if dataset["type"] == 2412:
        keys = ("element_nums", "fe_descriptor", "phys_table", "mat_table", "color")
        rows = [[e[k] for k in keys] + list(e["nodes_nums"]) for k, v in dataset.items() if isinstance(k, int) for e in v]
        result = {"type": 2412, "elements": sorted([int(x) for x in row] for row in rows)}
    return result


def same(expected, found):
    if expected == found:
        return True
    if isinstance(expected, dict):
        if not isinstance(found, dict):
            # A complex array without imaginary part.
            found = {"re": found, "im": np.zeros_like(np.asarray(found, float)).tolist()}
        return all(same(expected[k], found[k]) for k in ("re", "im"))
    if isinstance(expected, str) or (isinstance(expected, list) and expected and isinstance(expected[0], str)):
        return expected == found
    expected, found = np.asarray(expected, float), np.asarray(found, float)
    return expected.shape == found.shape and bool(np.all(expected == found))


def check(folder):
    with open(os.path.join(folder, "written.json")) as f:
        files = json.load(f)
    compared = 0
    for name, sets in files.items():
        uff = pyuff.UFF(os.path.join(folder, name))
        found = uff.read_sets()
        found = found if isinstance(found, list) else [found]
        assert [int(d["type"]) for d in found] == [d["type"] for d in sets], f"{name}: {[d['type'] for d in found]}"
        for expected, dataset in zip(sets, found):
            dataset = flat(dataset)
            for key, value in expected.items():
                assert key in dataset, f"{name}, dataset {expected['type']}: pyuff finds no {key}"
                assert same(value, dataset[key]), f"{name}, {expected['type']}.{key}: {value} != {dataset[key]}"
                compared += 1
    array = np.load(os.path.join(folder, "array.npy"))
    assert array.dtype == np.dtype("<c16") and array.flags.c_contiguous
    assert np.array_equal(array, (np.arange(6) / 3 - 1j * np.arange(6)).reshape(2, 3))
    print(f"pyuff {pyuff.__version__} reads {len(files)} files, {compared} fields equal")


def functions():
    """Functions in every form that pyuff writes."""
    rng = np.random.default_rng(58)
    n = 11
    for complex_values in (False, True):
        for spacing in (0, 1):
            for binary, double in ((0, True), (0, False), (1, True)):
                digits = 11 if double else 5
                data = rng.normal(size=n)
                if complex_values:
                    data = data + 1j * rng.normal(size=n)
                if not binary:
                    # What the columns hold.
                    short = lambda v: float(f"{v:.{digits}e}")
                    data = np.array([complex(short(v.real), short(v.imag)) if complex_values else short(v) for v in data])
                x = 2.0 + 0.25 * np.arange(n)
                if spacing == 0:
                    x = x + 0.125 * (np.arange(n) % 2)
                yield pyuff.prepare_58(
                    binary=binary, func_type=4 if complex_values else 1, rsp_node=12, rsp_dir=-3, ref_node=1, ref_dir=3,
                    rsp_ent_name="WING", ref_ent_name="NONE", data=data, x=x, id1="a function", id2="NONE", id3="NONE",
                    id4="NONE", id5="NONE", load_case_id=0, ver_num=0, abscissa_spacing=spacing, abscissa_spec_data_type=18,
                    ordinate_spec_data_type=12, orddenom_spec_data_type=13, ordinate_axis_units_lab="m/s^2",
                    ord_data_type=(6 if double else 5) if complex_values else (4 if double else 2)), double


def make(folder):
    sets = [
        (dict(type=151, model_name="wing", description="a test", db_app="app", program="pyuff", date_db_created="03-Jan-20",
              time_db_created="10:11:12", version_db1=1, version_db2=2, file_type=0, date_db_saved="03-Jan-20",
              time_db_saved="10:11:13", date_file_written="03-Jan-20", time_file_written="10:11:14"), True),
        (pyuff.prepare_164(units_code=5, units_description="mm (milli newton)", temp_mode=2, length=1000.0, force=1000.0,
                           temp=1.0, temp_offset=273.15), True),
        (pyuff.prepare_15(node_nums=[16, 17, 18], def_cs=[11, 11, 12], disp_cs=[16, 16, 17], color=[1, 3, 4],
                          x=[0.0, 1.53, -2.25], y=[0.0, 0.1, 3.84], z=[1.83, 0.0, -1.0e-3]), True),
        (pyuff.prepare_2411(node_nums=[1, 2], def_cs=[0, 0], disp_cs=[0, 1], color=[8, 8], x=[1 / 3, 2.0], y=[0.1, 0.2],
                            z=[-1.0e-17, 3.0]), True),
        (pyuff.prepare_82(trace_num=2, n_nodes=7, color=30, id="an outline", nodes=np.array([1, 10, 13, 14, 15, 16, 17])), True),
        (dict(type=2420, Part_UID=1, Part_Name="part", CS_sys_labels=[1, 2], CS_types=[0, 1], CS_colors=[8, 8],
              CS_names=["CS1", "CS2"], CS_matrices=[np.eye(4, 3), np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1], [1 / 3, 2, 3]])]), True),
        (dict(type=18, cs_num=[1, 2], cs_type=[0, 1], ref_cs_num=[0, 1], color=[8, 8], method=[1, 1], cs_name=["SYS1", "SYS2"],
              ref_o=[[0, 0, 0], [1.5, 0, -2]], x_point=[[1, 0, 0], [2.5, 0, -2]], xz_point=[[1, 0, 1], [1.5, 0, -1]]), True),
        (pyuff.prepare_55(model_type=1, id1="shape", id2="NONE", id3="NONE", id4="NONE", id5="NONE", analysis_type=2, data_ch=2,
                          spec_data_type=8, load_case=0, mode_n=3, freq=18.25, modal_m=2.5, modal_damp_vis=0.0125,
                          modal_damp_his=0.0, node_nums=[1, 2], r1=[0.5, -0.25], r2=[0.0, 1.0], r3=[1.25, 2.5e-3]), True),
        (pyuff.prepare_55(model_type=1, id1="shape", id2="NONE", id3="NONE", id4="NONE", id5="NONE", analysis_type=3, data_ch=2,
                          spec_data_type=8, load_case=0, mode_n=1, eig=-1.5 + 100.25j, modal_a=2 + 3j, modal_b=0.5 - 4j,
                          node_nums=[1, 2], r1=[0.5 + 1j, -0.25 - 2j], r2=[0.25j, 1 + 0j], r3=[1 + 1j, 2 - 1j]), True),
    ]
    sets += list(functions())
    np.save(os.path.join(folder, "array.npy"), np.asfortranarray((np.arange(6) / 3).reshape(2, 3).astype(">f4")))
    files = {}
    for number, (dataset, double) in enumerate(sets):
        name = f"made_{number:02}_{dataset['type']}.uff"
        path = os.path.join(folder, name)
        if os.path.exists(path):
            os.remove(path)
        expected = flat(dict(dataset))
        pyuff.UFF(path).write_sets(dict(dataset), mode="add", force_double=double)
        files[name] = [expected]
    with open(os.path.join(folder, "made.json"), "w") as f:
        json.dump(files, f)
    print(f"pyuff {pyuff.__version__} wrote {len(files)} files")


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2])
    elif sys.argv[1] == "check":
        check(sys.argv[2])
    else:
        print(pyuff.__version__)
