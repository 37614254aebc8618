"""What holds for every command: wrong usage, silence, JSON, pipes, help and the words of errors."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from cli_sheets import PLATE, SHEET

import kirigami as kg
from kirigami import cli
from kirigami.cli import demo
from kirigami.cli.options import in_words_of_the_command

COMMANDS = ["demo", "stretch", "accuracy", "mesh", "info", "export"]


@pytest.mark.parametrize(
    "words, meant",
    [
        (["strech", PLATE], "stretch"),
        (["stretch", PLATE, "--thikness", "1mm"], "--thickness"),
        (["stretch", PLATE, *SHEET, "--accuracy", "standart"], "standard"),
        (["mesh", PLATE, "--quiett"], "--quiet"),
        (["--verison"], "--version"),
    ],
)
def test_what_is_mistyped_is_answered_with_the_nearest_name(
    words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    assert capsys.readouterr().err.rstrip().endswith(f"did you mean {meant}?")


@pytest.mark.parametrize(
    "words",
    [
        ["demo", "--frames", "1"],
        ["demo", "--frames", "many"],
        ["unknown"],
        ["--unknown"],
        ["stretch", PLATE],
        ["stretch", PLATE, *SHEET, "--thickness", "3GPa"],
        ["stretch", PLATE, *SHEET, "--direction", "z"],
        ["stretch", PLATE, *SHEET, "--direction", "nan"],
        ["stretch", PLATE, *SHEET, "--nodes", "0"],
        ["stretch", PLATE, *SHEET, "--seed", "-1"],
        ["stretch", PLATE, *SHEET, "--nu", "many"],
        ["stretch", PLATE, *SHEET, "--part", "one"],
        ["accuracy", PLATE, "--error", "-1%"],
        ["accuracy", PLATE, "--tol", "nan"],
        ["accuracy", PLATE, "--sizes", "5mm", "0"],
        ["stretch", PLATE, *SHEET, "--accuracy", "best"],
        ["mesh", PLATE, "--max-edge", "2 cubits"],
        ["export", PLATE],
    ],
)
def test_wrong_usage_ends_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("usage: kirigami")
    assert not re.search(r"invalid (_|float|int)", said)  # the name of a function or a type is no help


@pytest.mark.parametrize("value, meant", [("-5%", -0.05), ("-0.05", -0.05), ("-.05", -0.05), ("-5e-2", -0.05)])
def test_quantities_below_zero_are_written_like_others(value: str, meant: float) -> None:
    """Python's parser takes -5 for a value, and -5% for an option that is not there."""
    options = cli.make_parser().parse_args(["stretch", PLATE, *SHEET, "--strain", value, "--lift", "-1mm,0", "2mm"])
    assert options.strain == pytest.approx(meant) and options.lift == [["-1mm,0", "2mm"]]


def test_what_must_not_be_below_zero_is_said_to_be_so(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["stretch", PLATE, "--thickness", "0.1mm", "--E", "-3.5GPa"])
    assert capsys.readouterr().err.endswith("argument --E: '-3.5GPa': must be positive\n")


@pytest.mark.parametrize("words", [["demo"], ["stretch", PLATE, *SHEET], ["accuracy", PLATE]])
def test_a_folder_that_is_a_file_is_told(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "report"
    file.write_text("not to be lost")
    for folder in (file, file / "inside"):
        assert cli.main([*words, "--folder", str(folder)]) == 1
        assert capsys.readouterr().err == f"kirigami: cannot make the folder {folder}: {file} is a file\n"
    assert file.read_text() == "not to be lost"


def test_wrong_units_are_explained(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["stretch", PLATE, "--thickness", "0.1mm", "--E", "3.5gpa"])
    assert "argument --E: '3.5gpa': the unit 'gpa' is unknown (did you mean GPa?)" in capsys.readouterr().err


def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    said = capsys.readouterr().err
    assert all(f"  kirigami {command} " in said for command in COMMANDS)


def test_an_error_of_the_package_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise kg.GeometryError("the cuts sever the sheet")

    monkeypatch.setattr(demo, "demo_sheet", broken)
    assert cli.main(["demo", "--folder", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "kirigami: the cuts sever the sheet\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_quick_and_fits(command: str) -> None:
    """Asking for help must not load what only the analysis and the pictures need; examples must be right."""
    program = (
        "import sys, kirigami.cli as cli\n"
        f"try: cli.main(['{command}', '--help'])\n"
        "except SystemExit as end: code = end.code\n"
        "heavy = {'matplotlib', 'shapely', 'triangle', 'scipy.sparse.linalg'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else code)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--json" in done.stdout and "--quiet" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    examples = [line.strip() for line in done.stdout.splitlines() if line.strip().startswith(f"kirigami {command}")]
    assert examples
    for example in examples:
        words = example.partition(" |")[0].partition("    ")[0].split()[1:]
        assert cli.make_parser().parse_args(words).command == command


def test_commands_on_pages_are_ones_that_there_are() -> None:
    """With all their options, and values of the right kind."""
    root = Path(__file__).parents[2]
    pages = [root / "README.md", *sorted((root / "docs").glob("*.md")), *sorted((root / "tutorials").glob("*.py"))]
    found = 0
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for line in re.findall(r"^(?:# |\$ )?(kirigami [a-z]+ [^#\n]+)", text, re.MULTILINE):
            words = shlex.split(line)[1:]
            assert cli.make_parser().parse_args(words).command == words[0], f"{page.name}: {line}"
            found += 1
    assert found > 10


@pytest.mark.parametrize("page", ["command_line", "drawings", "maker_session"])
def test_options_on_pages_are_ones_that_there_are(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    there = set()
    for command in COMMANDS:
        with pytest.raises(SystemExit):
            cli.main([command, "--help"])
        there |= set(re.findall(r"--[\w-]+", capsys.readouterr().out))
    text = (Path(__file__).parents[2] / "docs" / f"{page}.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))
    assert named and named <= there, named - there


def test_a_closed_pipe_ends_quietly() -> None:
    """`kirigami info plate.svg | head -0`: nobody reads, and that is no error."""
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "kirigami.cli", "info", PLATE, "--no-picture"],
        stdout=write, stderr=subprocess.PIPE, check=False,
    )  # fmt: skip
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


RESULTS = "made.npz"
TABLE = {
    "demo": ["--folder", "d", "--frames", "2"],
    "stretch": [PLATE, *SHEET, "--folder", "s"],
    "accuracy": [PLATE, "--sizes", "40mm", "--stiffness", "plate", "--strain", "0.05%", "--reference", "shell.csv",
                 "--tolerance", "1mm", "--folder", "a"],
    "mesh": [PLATE, "--max-edge", "20mm", "-o", "m.fold"],
    "info": [PLATE],
    "export": [RESULTS, "x.csv", "x.html"],
}  # fmt: skip
LENGTHY = ("demo", "stretch", "accuracy")


def test_the_table_holds_every_command() -> None:
    from argparse import _SubParsersAction

    (commands,) = (item for item in cli.make_parser()._actions if isinstance(item, _SubParsersAction))
    assert set(commands.choices) == set(TABLE)


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that the table of commands names."""
    monkeypatch.chdir(tmp_path)
    m = kg.Model(dim=2, name="bar")
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    kg.LinearStatic(m).run().save(tmp_path / RESULTS)
    (tmp_path / "shell.csv").write_text("load_factor,force\n0,0\n0.5,10\n1,20\n")
    return tmp_path


# Of the demo and of stretch, which take seconds, the tests of their own say it.
@pytest.mark.parametrize("command", [command for command in TABLE if command not in ("demo", "stretch")])
@pytest.mark.filterwarnings("ignore")
def test_every_command_is_silent_or_speaks_json(
    command: str, plain: None, workplace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """0 where all went well; --quiet leaves stdout empty; --json leaves one object there and nothing else."""
    if command not in LENGTHY:
        assert cli.main([command, *TABLE[command], "--quiet"]) == 0
        said = capsys.readouterr()
        assert said.out == "" and "Traceback" not in said.err
    assert cli.main([command, *TABLE[command], "--json", "--quiet"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), dict)
    assert not list(workplace.rglob("*.part*"))


@pytest.mark.parametrize("command", TABLE)
def test_every_command_ends_with_2_for_wrong_usage_and_with_1_for_a_missing_file(
    command: str, workplace: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main([command, *TABLE[command], "--no-such-option"])
    assert ended.value.code == 2 and "usage: kirigami" in capsys.readouterr().err
    words = ["absent.dxf" if word in (PLATE, RESULTS) else word for word in TABLE[command]]
    if command == "demo":
        (workplace / "d").write_text("a file where the folder is to be")
    assert cli.main([command, *words]) == 1
    said = capsys.readouterr().err
    assert said.startswith("kirigami: ") and len(said.splitlines()) == 1
    assert ("d" if command == "demo" else "absent.dxf") in said


READ = [["--help"], *([command, "--help"] for command in TABLE)]
READ += [[command, *words, "--json"] for command, words in TABLE.items() if command not in LENGTHY]


@pytest.mark.parametrize("words", READ)
@pytest.mark.filterwarnings("ignore")
def test_a_reader_that_has_enough_is_no_error(
    words: list[str], coarse: None, short: None, plain: None, workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`kirigami ... | head -0`, for the help as well; nothing is left for Python to complain about as it ends."""
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        assert cli.main(words) == 0
        closed.flush()


def test_hints_speak_the_language_of_the_command_line() -> None:
    for python, command in (
        ("use a mesh without a pattern, or stiffness='shell'", "use a mesh without a pattern, or --stiffness shell"),
        ("by 3. kirigami.stiffness.report(mesh) has the numbers; use a finer mesh", "by 3; use a finer mesh"),
        ("Hint: the path so far is in error.results; another amplitude", "Hint: what was found is written; another"),
        ("LoadCase: rim is held", "rim is held"), ("give `max_edge=2`", "give --max-edge 2"),
        ("energy of 0.002 (force times length) was set free", "energy of 0.002 J was set free"),
        ("width 0.015 (in the unit of the sheet) has", "width 0.015 (in metres) has"),
    ):  # fmt: skip
        assert in_words_of_the_command(python).startswith(command)
