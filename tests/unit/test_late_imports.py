"""What takes long to import: never while a clock runs, and never for those who do not need it."""

import subprocess
import sys
from pathlib import Path

import pytest

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"

_RENDERS = """
import sys
import equaltime as et
scene, before = et.load(sys.argv[1]).with_(size=(12, 12)), set()
def passed(_):
    if not before:
        before.update(sys.modules)
{}
assert before
print(*sorted(sys.modules.keys() - before))
"""


def printed(program: str) -> str:
    run = subprocess.run([sys.executable, "-c", program, str(SCENE)], capture_output=True, text=True, check=True)
    return run.stdout.strip()


@pytest.mark.parametrize(
    "call",
    [
        "et.render(scene, time=0.1, observer=et.Observer.of(quoted=passed, progress=passed))",
        "et.render(scene, error=0.5, observer=et.Observer.of(quoted=passed, progress=passed))",
        "et.render(scene, spp=512, observer=et.Observer.of(progress=passed))",
        "et.quote(scene, error=0.5, why=False, progress=passed)",
    ],
)
def test_nothing_is_imported_once_the_first_pass_has_ended(call: str) -> None:
    assert printed(_RENDERS.format(call)) == ""


@pytest.mark.parametrize(
    "call",
    [
        "from equaltime.cli import main; main(['--help'])",
        "import equaltime as et; et.render(et.load(sys.argv[1]).with_(size=(96, 96)), spp=16)",
    ],
)
def test_who_asks_for_no_limit_of_an_error_does_not_wait_for_quantiles(call: str) -> None:
    assert printed(f"import sys; {call}; print('scipy' in sys.modules)").endswith("False")


def test_a_scene_of_another_format_does_not_wait_for_the_classes_of_gltf() -> None:
    program = "import sys, equaltime as et; et.load(sys.argv[1]); print('pygltflib' in sys.modules)"
    assert printed(program) == "False"
