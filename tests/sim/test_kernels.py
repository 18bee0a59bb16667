"""The compiled flight loop against the same functions run as plain Python."""

import json
import os
import subprocess
import sys

import pytest

from sim import kernels

FLIGHT = """
import json
from sim import Spacecraft, SpacecraftConfig
craft = Spacecraft(SpacecraftConfig(wheel_initial_speed_rad_s=300.0, engine_start_s=(5.0, 6.0)), 3)
craft.send("acs.point", {"target": "asteroid_b"})
craft.send("ips.start", {})
seen = []
for second in range(1, 301):
    craft.advance(second)
    if second == 20:
        craft.send("ips.thrust", {"level": 69})
    if second == 120:
        craft.send("acs.actuators", {"name": "thrusters"})
    if second == 220:
        craft.send("acs.actuators", {"name": "wheels"})
        craft.send("acs.unload", {})
    if second % 20 == 0:
        seen.append(craft.telemetry())
print(json.dumps(seen))
"""


def fly(**environment):
    run = subprocess.run(
        [sys.executable, "-c", FLIGHT], capture_output=True, text=True, check=True, env={**os.environ, **environment}
    )
    return json.loads(run.stdout)


def test_compiled_and_plain_fly_the_same():
    if not kernels.HAS_NUMBA:
        pytest.skip("nothing to compare without numba")
    compiled, plain = fly(), fly(NUMBA_DISABLE_JIT="1")
    for one, other in zip(compiled, plain, strict=True):
        for channel, value in one.items():
            if isinstance(value, float):
                assert other[channel] == pytest.approx(value, rel=1e-6, abs=2e-6), channel
            else:
                assert other[channel] == value, channel


CALLS = """
import sys
from sim import kernel_cache
kernel_cache.__file__ = sys.argv[1] + "/any.py"
sys.path.insert(0, sys.argv[1])
import outer
print(outer.outer(1.0), sum(outer.outer.stats.cache_hits.values()))
"""


def test_a_changed_inner_function_in_another_file_is_compiled_anew(tmp_path):
    if not kernels.HAS_NUMBA:
        pytest.skip("nothing is compiled without numba")
    head = "from sim.kernels import compiled\n"
    (tmp_path / "outer.py").write_text(
        f"{head}from inner import inner\n\n@compiled\ndef outer(x):\n    return inner(x)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONDONTWRITEBYTECODE": "1"}

    def call():
        command = [sys.executable, "-c", CALLS, str(tmp_path)]
        return subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout.split()

    (tmp_path / "inner.py").write_text(f"{head}\n@compiled\ndef inner(x):\n    return x + 1.0\n")
    assert call() == ["2.0", "0"]
    assert call() == ["2.0", "1"]
    (tmp_path / "inner.py").write_text(f"{head}\n@compiled\ndef inner(x):\n    return x + 2.0\n")
    assert call() == ["3.0", "0"]


def test_without_numba_functions_stay_as_they_are(monkeypatch):
    monkeypatch.setattr(kernels, "HAS_NUMBA", False)

    def function(x):
        return x + 1

    assert kernels.compiled(function) is function
