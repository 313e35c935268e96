"""The program beside: each run is whole on the page, and what cannot be put there is refused."""

from collplan_ros.run.page import write_run_page
from collplan_ros.run.page.beside import main
from played_folders import played_folder, recording_in, recordings_in

WRITTEN, REFUSED = 0, 2


def test_a_page_holds_each_run_as_its_own_page_does(tmp_path):
    folders = [played_folder(tmp_path, strategy=strategy, run=strategy) for strategy in ("avoid", "bounce")]
    out = tmp_path / "both.html"
    assert main([*map(str, folders), "--out", str(out)]) == WRITTEN
    own = [recording_in(write_run_page(folder).read_text(encoding="utf-8")) for folder in folders]
    assert recordings_in(out.read_text(encoding="utf-8")) == own


def test_one_run_two_worlds_or_no_folder_to_write_to_are_refused(tmp_path, capsys):
    one, same, other = (played_folder(tmp_path / at, run=run) for at, run in (("a", "1"), ("a", "2"), ("b", "1")))
    out = tmp_path / "no.html"
    for runs, to, said in (
        ([one], out, "at least two"),
        ([one, other], out, "one world"),
        ([one, same], one, "written"),
    ):
        assert main([*map(str, runs), "--out", str(to)]) == REFUSED
        assert said in capsys.readouterr().err
    assert not out.exists()
