#!/bin/sh
# Build the wheel and the source distribution, look into them, and use them in clean environments.
#
#     tools/check_packaging.sh [PYTHON ...]
#
# For each interpreter (default: python3) the wheel is installed into an environment of its own, with the newest
# releases of what it needs; for Python 3.10 also with the oldest ones that setup.cfg allows. Only binary packages are
# taken, so nobody needs a compiler. In each environment the package must import without a warning, follow a snapping
# truss, mesh and draw a cut sheet, and answer on the command line.
#
# CHECK=suite also installs the extras and runs the docstring examples and the core tests of the source distribution.
# CHECK=extras also makes an environment without any extra and one for each extra alone, and runs in each the first
# script of the README and the command line on a drawing.
# Needs a package index. Leaves nothing behind.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MPLBACKEND=Agg PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH || true
[ $# -gt 0 ] || set -- python3

fail() {
    echo "check_packaging: $*" >&2
    exit 1
}

quietly() { # a command whose output matters only when it fails
    "$@" >"$work/log" 2>&1 || {
        tail -n 40 "$work/log" >&2
        fail "failed: $*"
    }
}

# ---- build: the wheel is made from the source distribution, so that one must be complete

mkdir "$work/source"
tar -C "$root" --exclude=.git --exclude=.venv --exclude=build --exclude=dist --exclude='*.egg-info' --exclude='.*_cache' -cf - . |
    tar -C "$work/source" -xf -
quietly "$1" -m venv "$work/builder"
quietly "$work/builder/bin/python" -m pip install build
quietly "$work/builder/bin/python" -m build --outdir "$work/dist" "$work/source"
wheel=$(echo "$work"/dist/*.whl)
sdist=$(echo "$work"/dist/*.tar.gz)

# ---- contents

"$1" -m zipfile -l "$wheel" | awk 'NR > 1 {print $1}' >"$work/wheel.txt"
tar -tzf "$sdist" | sed 's|^[^/]*/||' >"$work/sdist.txt"
for file in kirigami/py.typed kirigami/io/page.html; do
    grep -qx "$file" "$work/wheel.txt" || fail "the wheel lacks $file"
done
grep -q '\.dist-info/.*LICENSE$' "$work/wheel.txt" || fail "the wheel lacks LICENSE"
if grep -vE '^(kirigami/|kirigami_mechanics-[^/]*\.dist-info/)' "$work/wheel.txt"; then
    fail "the wheel holds more than the package"
fi
for file in LICENSE README.md CHANGELOG.md tests/test_public_names.py tests/data/ examples/; do
    grep -q "^$file" "$work/sdist.txt" || fail "the source distribution lacks $file"
done
(cd "$work/source" && find kirigami -name '*.py' | sort) >"$work/modules.txt"
for list in wheel sdist; do
    sort "$work/$list.txt" | grep '^kirigami/.*\.py$' | diff "$work/modules.txt" - >&2 ||
        fail "the modules in the $list are not those of the source tree"
done
echo "built $(basename "$wheel") and $(basename "$sdist"); contents right"

# ---- use

cat >"$work/use.py" <<'USE'
import sys

import numpy as np
import shapely

import kirigami as kg

assert kg.__file__.startswith(sys.prefix), f"imported from {kg.__file__}, not from the installed wheel"

# The snapping truss: two bars of EA = 1 from (-1, 0) and (1, 0) to (0, 1), Green strain: P = h (1 - h^2) / sqrt(8),
# h the height of the apex, has its maximum 0.1360828 at h = 1 / sqrt(3).
truss = kg.Model(dim=2)
left, apex, right = truss.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
truss.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
truss.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
snap = kg.ArcLength(truss, step=0.02, stop=lambda step: step.u[1, 1] < -2).run()
assert [event.kind for event in snap.events] == ["limit point"] * 2
assert np.isclose(snap.events[0].lam, 2 / (3 * np.sqrt(3)) / np.sqrt(8), rtol=1e-6)

slit = shapely.LineString([(-0.03, 0), (0.03, 0)])
sheet = kg.Sheet(shapely.box(-0.05, -0.05, 0.05, 0.05), [slit], thickness=1e-4, material=kg.Material(E=3.5e9, nu=0.34))
model = kg.Model.from_mesh(sheet.mesh(max_edge=0.02))
top = model.select(boundary="top")
model.add(kg.Fix(model.select(boundary="bottom")), kg.Fix(top, "xz"), kg.Prescribe(top, y=1e-4))
pulled = kg.LinearStatic(model).run()
assert pulled.reaction(top, "y")[-1] > 0
pulled.plot().figure.savefig(sys.argv[1])
USE

use() { # name, environment, constraints on versions
    cd "$work"
    quietly "$2/bin/python" -W error -c "import kirigami"
    quietly "$2/bin/python" "$work/use.py" "$work/picture.png"
    test -s "$work/picture.png" || fail "$1: no picture was drawn"
    quietly "$2/bin/kirigami" --version
    if [ "${CHECK:-}" = suite ]; then
        quietly "$2/bin/python" -m pip install --prefer-binary "$wheel[io,viz]" -c "$3" pytest hypothesis
        mkdir -p "$2/suite" && tar -C "$2/suite" --strip-components=1 -xzf "$sdist"
        # The suite imports what is installed, not the sources it came with.
        package=$("$2/bin/python" -c 'import kirigami; print(kirigami.__path__[0])')
        (cd "$2/suite" && rm -r kirigami &&
            quietly "$2/bin/python" -m pytest -p no:cacheprovider -m "not long and not external" \
                "$package" tests/mechanics tests/geometry tests/io tests/test_public_names.py)
    fi
    cd "$root"
    echo "$1: $("$2/bin/python" -m pip list 2>/dev/null | grep -E '^(numpy|scipy|shapely|triangle|matplotlib) ' |
        awk '{printf "%s %s  ", $1, $2}')"
}

newcomer() { # name, environment: what the README shows first, and a drawing
    cd "$work"
    printed=$("$2/bin/python" -W ignore "$work/readme.py") || fail "$1: the README's first script failed"
    rm -rf "$work/report"
    # A film with a slit of two fifths of its width, pulled by two per cent: seconds.
    quietly "$2/bin/kirigami" info "$work/sheet.geojson"
    quietly "$2/bin/kirigami" stretch "$work/sheet.geojson" --thickness 0.2mm --E 3.5GPa --strain 2% \
        --accuracy draft --nodes 300 --folder "$work/report"
    for file in report.json curves.csv results.npz; do
        test -s "$work/report/$file" || fail "$1: no $file was written"
    done
    cd "$root"
    echo "$1: $printed; $(ls "$work/report" | tr '\n' ' ')"
}

if [ "${CHECK:-}" = extras ]; then
    awk '/^```python/ {on = 1; next} /^```/ {if (on) exit} on' "$root/README.md" >"$work/readme.py"
    cat >"$work/sheet.geojson" <<'SHEET'
{"type": "FeatureCollection", "unit": "mm", "features": [
 {"type": "Feature", "properties": {"layer": "outline"}, "geometry":
  {"type": "Polygon", "coordinates": [[[0, 0], [100, 0], [100, 80], [0, 80], [0, 0]]]}},
 {"type": "Feature", "properties": {"layer": "cuts"}, "geometry":
  {"type": "LineString", "coordinates": [[30, 40], [70, 40]]}}]}
SHEET
    extras=$(cd "$work" && "$1" -c '
import sys, zipfile
with zipfile.ZipFile(sys.argv[1]) as wheel:
    (name,) = [name for name in wheel.namelist() if name.endswith("/METADATA")]
    lines = wheel.read(name).decode().splitlines()
print(*[line.split()[1] for line in lines if line.startswith("Provides-Extra") and line.split()[1] not in ("dev", "docs")])
' "$wheel")
    quietly "$1" -m venv "$work/bare"
    quietly "$work/bare/bin/python" -m pip install --only-binary :all: "$wheel"
    newcomer "without extras" "$work/bare"
    for extra in $extras; do
        quietly "$1" -m venv "$work/extra_$extra"
        quietly "$work/extra_$extra/bin/python" -m pip install --only-binary :all: "$wheel[$extra]"
        newcomer "extra $extra alone" "$work/extra_$extra"
        rm -rf "$work/extra_$extra"
    done
fi

count=0
for python in "$@"; do
    count=$((count + 1))
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    quietly "$python" -m venv "$work/newest$count"
    quietly "$work/newest$count/bin/python" -m pip install --only-binary :all: "$wheel"
    use "Python $version, newest" "$work/newest$count" /dev/null
    if [ "$version" = 3.10 ]; then
        (cd "$work" && "newest$count/bin/python" -c '
from importlib.metadata import requires
pins = (line.partition(";")[0].strip() for line in requires("kirigami-mechanics") if "dev" not in line)
print(*sorted({pin.replace(">=", "==") for pin in pins}), sep="\n")
') >"$work/oldest.txt"
        quietly "$python" -m venv "$work/oldest$count"
        quietly "$work/oldest$count/bin/python" -m pip install --only-binary :all: "$wheel" -c "$work/oldest.txt"
        use "Python $version, oldest" "$work/oldest$count" "$work/oldest.txt"
    fi
done
