"""Damage in a store: every byte of its descriptions, and files that stand in another one's place."""

import itertools
import random
import shutil

import numpy as np
import pytest
import xarray
import zarr
from vibroscope.engine import Cancelled, EtaStudy, Reference, System
from vibroscope.engine.sweeps import check_store
from vibroscope.engine.sweeps.store import Store
from vibroscope.engine.sweeps.store_location import FOLDER, STUDY, StoreLocation, read_seal

from tests.engine.store_files import files
from tests.share import every, share
from tests.studies import sweep_of

ETAS = np.linspace(2.6, 3.3, 8)


def swept(out=None, **more):
    how = {"transient": 60, "sample": 5, "coordinates": ["xi2"], "cells_per_chunk": 4, **more}
    return sweep_of(EtaStudy, System(), Reference(), values=ETAS, out=out, **how)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept") / "whole.zarr"
    swept(folder)
    return folder


@pytest.fixture
def store(whole, tmp_path):
    """A copy of a whole store."""
    return shutil.copytree(whole, tmp_path / "store.zarr")


def descriptions(folder):
    """Every file that holds no numbers: the manifest and what Zarr says of the arrays."""
    return [str(path.relative_to(folder)) for path in sorted(folder.rglob("*.json"))]


def changed(content, at):
    return content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1 :]


class Held:
    """A place whose files are held in memory."""

    def __init__(self, contents):
        self.read = contents.get


def test_every_changed_byte_of_a_description_is_found(whole):
    contents = {name: (whole / name).read_bytes() for name in descriptions(whole)} | files(whole)
    names = [name for name in descriptions(whole) if not name.startswith(FOLDER) or name == STUDY]
    assert Store(Held(contents)).damaged_files() == []
    # every byte of an array with one dimension and of one with two; the others are like these, the group repeats all
    thorough, inputs = {STUDY, "period/zarr.json", "xi2/zarr.json"}, 0
    assert thorough <= set(names)
    for name in names:
        for at in every(range(0, len(contents[name]), 1 if name in thorough else 5)):
            assert Store(Held(contents | {name: changed(contents[name], at)})).damaged_files() == [name], at
            inputs += 1
    assert inputs > share(2000)


def test_every_changed_byte_of_a_seal_is_found(store):
    key = Store(StoreLocation(store)).read_manifest().origin["key"]
    content, first = (store / FOLDER / "0.json").read_bytes(), (slice(0, 4),)
    good = read_seal(content, key, first)
    assert good
    for at in range(len(content)):
        assert read_seal(changed(content, at), key, first) is None


def test_a_run_after_damage_gives_the_same_files_or_says_which_file_is_damaged(whole, store):
    """In every description one byte is changed, at once; where the manifest is lost, the seals vouch for the chunks."""
    chance, good = random.Random(1), files(whole)
    for without_seals in [False] * share(8) + [True] * share(4):
        damaged = []
        for name in descriptions(whole):
            content = (whole / name).read_bytes()
            seal = name.startswith(FOLDER) and name != STUDY
            if without_seals or not seal:
                content, damaged = changed(content, chance.randrange(len(content))), [*damaged, name]
            (store / name).write_bytes(content)
        if without_seals:
            refusal = ""
            try:
                swept(store)
            except ValueError as problem:
                refusal = str(problem)
            assert any(name in refusal for name in damaged) if refusal else files(store) == good
        else:
            assert swept(store).attrs["reused"] == 8
            assert files(store) == good
            assert check_store(store) == ([], True)


def test_a_manifest_that_is_damaged_is_written_anew_while_the_chunks_have_their_seals_else_refused(whole, store):
    (store / STUDY).write_text("{")
    assert check_store(store) == ([STUDY], False)
    assert swept(store).attrs["reused"] == 8
    assert files(store) == files(whole)
    (store / STUDY).write_text("{")
    (store / FOLDER / "0.json").unlink()
    with pytest.raises(ValueError, match=f"{STUDY} is damaged"):
        swept(store)


def test_a_seal_that_is_damaged_costs_its_chunk(whole, store):
    (store / FOLDER / "4.json").write_text("{}")
    assert check_store(store) == ([f"{FOLDER}/4.json"], True)
    assert swept(store).attrs["computed"] == 4
    assert files(store) == files(whole)


def chunks_of(folder):
    """Files with the numbers of a chunk: pairs of an array's name and the file's path below the store."""
    return [(name.split("/")[0], name) for name in files(folder) if "/c/" in name]


def test_a_chunk_in_the_place_of_another_is_found_and_computed_anew(whole, store):
    """Every chunk in every other one's place: of another array, and of other cells."""
    good, found = files(whole), 0
    pairs = list(itertools.permutations([name for _, name in chunks_of(whole)], 2))
    for into, source in random.Random(2).sample(pairs, share(24)):
        (store / into).write_bytes(good[source])
        if good[into] != good[source]:
            assert check_store(store)[0] == [into]
            found += 1
        (store / into).write_bytes(good[into])
    assert found > share(10)
    for into, source in random.Random(3).sample(pairs, 3):
        (store / into).write_bytes(good[source])
        xarray.testing.assert_equal(swept(store).load(), xarray.open_zarr(whole).load())
        assert files(store) == good


def test_a_description_or_all_chunks_of_another_array_are_found(whole, store):
    (store / "spread" / "zarr.json").write_bytes((store / "period" / "zarr.json").read_bytes())
    shutil.rmtree(store / "contact_share")
    shutil.copytree(store / "longest_contact", store / "contact_share")
    assert {"spread/zarr.json", "contact_share/zarr.json"} <= set(check_store(store)[0])
    swept(store)
    assert files(store) == files(whole)


def test_whole_cells_in_the_place_of_others_are_found(whole, store):
    """Every array's chunk and the seal of it, too."""
    good = files(whole)
    for name in good:
        if name.endswith("/c/0") or name.endswith("/c/0/0"):
            other = name[: -len("/0")] + "/1" if name.endswith("/c/0") else name[: -len("/0/0")] + "/1/0"
            if other in good:
                (store / name).write_bytes(good[other])
    shutil.copy(store / FOLDER / "4.json", store / FOLDER / "0.json")
    assert check_store(store)[0] == [f"{FOLDER}/0.json"]
    assert swept(store).attrs["computed"] == 4
    assert files(store) == good


def test_a_store_without_a_manifest_is_refused_in_words(store):
    shutil.rmtree(store / FOLDER)
    before = files(store)
    with pytest.raises(ValueError, match=f"has no {STUDY}, either lost or not yet written"):
        swept(store)
    assert files(store) == before
    assert check_store(store) == ([STUDY], False)
    with pytest.raises(ValueError, match="no result of a sweep"):
        check_store(store / "nowhere")


def test_what_a_plain_reader_sees_of_a_missing_chunk(store):
    """As docs/sweeps.md says."""
    (store / "xi2" / "c" / "0" / "0").unlink()
    assert np.isnan(xarray.open_zarr(store)["xi2"][:4]).all()
    assert check_store(store) == (["xi2/c/0/0"], True)


def test_rounds_of_a_refined_study_are_looked_through(tmp_path):
    swept(tmp_path / "a.zarr", refine=1)
    assert check_store(tmp_path / "a.zarr") == ([], True)
    (tmp_path / "a.zarr" / "round-0" / "period" / "c" / "0").unlink()
    assert check_store(tmp_path / "a.zarr") == (["round-0/period/c/0"], True)
    swept(tmp_path / "a.zarr", refine=1)
    assert check_store(tmp_path / "a.zarr") == ([], True)


def test_a_changed_bit_of_a_seal_is_damage_of_the_seal_alone(store):
    """It was once reported as damage of the chunk."""
    file = store / FOLDER / "4.json"
    content = file.read_bytes()
    at = content.index(b"numbers") + 30  # in the digest of some numbers
    file.write_bytes(content[:at] + (b"0" if content[at : at + 1] != b"0" else b"1") + content[at + 1 :])
    assert check_store(store) == ([f"{FOLDER}/4.json"], True)


def test_a_deleted_chunk_of_fill_values_is_found_and_written_again(store):
    """Where a chunk has no file, Zarr gives fill values: those of an empty chunk are right."""
    kept, first = Store(StoreLocation(store)), (slice(0, 4),)
    assert list(kept.damaged_chunks()) == []  # it is open now
    values = kept.read(first)
    kept.write_now(first, values | {"period": np.full(4, zarr.open_array(store, path="period").fill_value)})
    assert check_store(store) == ([], True)
    (store / "period/c/0").unlink()
    assert check_store(store) == (["period/c/0"], True)
    assert kept.read(first) is None  # so that a run computes it anew


def test_a_folder_in_the_place_of_a_seal_is_found_before_the_sweep_is_finished(tmp_path):
    seen = []
    with pytest.raises(Cancelled):
        swept(tmp_path / "half.zarr", progress=seen.append, cancelled=lambda: bool(seen))
    (tmp_path / "half.zarr" / FOLDER / "4.json").mkdir()
    assert check_store(tmp_path / "half.zarr") == ([f"{FOLDER}/4.json"], False)


def test_files_that_are_not_its_own_are_named(store):
    for name in ("notes.txt", "period/c/77", "round-7/zarr.json"):
        (store / name).parent.mkdir(parents=True, exist_ok=True)
        (store / name).write_text("{}")
    assert check_store(store) == (["notes.txt", "period/c/77", "round-7/zarr.json"], True)
