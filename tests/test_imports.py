"""What commands import, and that tests and benchmarks meet in `tests.shared` alone."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from retrodict.report.figures import registry as figures
from retrodict.result import Result
from tests.report.conftest import make_outcome

ROOT = Path(__file__).parents[1]


def imports(folder: str) -> Iterator[tuple[str, str]]:
    """Every file of a folder with each module of tests or benchmarks that it imports."""
    for file in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert not node.level, f"{file}: a relative import"
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            for name in names:
                if name.startswith(("tests", "benchmarks")):
                    yield str(file.relative_to(ROOT)), name


def test_benchmarks_import_of_the_tests_only_what_is_shared() -> None:
    found = list(imports("benchmarks"))
    assert ("benchmarks/kinks.py", "tests.shared.reference") in found
    assert not [each for each in found if not each[1].startswith(("tests.shared.", "benchmarks"))]


def test_what_is_shared_imports_neither() -> None:
    found = list(imports("tests/shared"))
    assert not [each for each in found if not each[1].startswith("tests.shared.")]


def test_only_the_tests_of_benchmarks_import_them() -> None:
    found = [file for file, name in imports("tests") if name.startswith("benchmarks")]
    assert found
    assert not [file for file in found if not file.startswith("tests/benchmarks/")]


# a stand-in that nothing has looked into is no import: JAX itself is `jax._src`
JAX = ("jax._src", "numpyro.infer", "diffrax")
PLOTS = ("matplotlib", "PIL")
STATISTICS = ("scipy.stats", "arviz_stats", "xarray", "pandas", "h5netcdf")
SCENE = ROOT / "examples" / "brach-1977" / "scene.toml"


def imported(code: str, *names: str) -> list[str]:
    """Which modules a fresh process has imported when it has run some code."""
    ask = f"import sys\n{code}\nprint(*(set({names!r}) & set(sys.modules)), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    return done.stderr.split()


def after(*arguments: str) -> str:
    """Code that runs a command."""
    return (
        "from contextlib import suppress\nfrom retrodict.cli import app\n"
        f"with suppress(SystemExit): app({list(arguments)!r})"
    )


def test_what_imports_is_noticed() -> None:
    assert imported("import scipy.stats", "scipy.stats", "pandas") == ["scipy.stats"]


def test_help_imports_no_library_of_the_work() -> None:
    assert not imported(after("--help"), "numpy", "pydantic", *JAX, *PLOTS, *STATISTICS)


def test_check_imports_what_reads_a_scene_only() -> None:
    assert not imported(after("check", str(SCENE)), "scipy", "pint", *JAX, *PLOTS, *STATISTICS)


def test_a_reconstruction_imports_statistics_and_plots_while_programs_load() -> None:
    assert not imported("import retrodict.api", *PLOTS, *STATISTICS)


def test_report_figures_and_export_do_without_jax(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "FIGURES", {})  # they are drawn by the report
        Result(make_outcome()).save(folder)
    report = after("report", str(folder), "--format", "html,pdf,docx", "--quiet")
    assert imported(report, *JAX, "arviz_stats") == ["arviz_stats"]
    assert (folder / "report.docx").is_file()
    export = after("export", str(folder), "--quiet")
    assert imported(export, *JAX, "pyarrow") == ["pyarrow"]
    assert (folder / "export" / "scene.dxf").is_file()


def test_models_work_after_arviz() -> None:
    """ArviZ leaves a stand-in for NumPyro, which `import numpyro.distributions` would load twice."""
    code = (
        "import arviz\nimport retrodict.inference.own\n"
        "import numpyro\nfrom numpyro import handlers\n"
        "handlers.block(lambda: numpyro.factor('known', 0.0))()"
    )
    assert not imported(code, "retrodict.cli")
