# What .ci/run and .ci/long begin with: a copy of the tracked and the new files, in a path with a blank and umlauts, with a
# cache of its own. Sourced in the root of the repository; afterwards the working directory is the copy.
set -euo pipefail

work=$(mktemp -d)
# However it ends, the last line says so.
at="preparation"
processes=()
leave() {
    local code=$? each
    for each in "${processes[@]}"; do kill -- "-$each" 2>/dev/null || true; done
    if [ "$code" -ne 0 ]; then echo "FAILED in: $at (exit $code)"; fi
    rm -rf "$work"
}
trap leave EXIT
copy="$work/prüf stand"
mkdir -p "$copy"
git ls-files -co --exclude-standard -z | while IFS= read -r -d '' file; do
    if [ -e "$file" ]; then printf '%s\0' "$file"; fi
done | tar -c --null -T - | tar -x -C "$copy"
cd "$copy"
# Python compiles what it imports, and keeps it in the copy; pip would compile all that it installs, on one core.
unset PYTHONDONTWRITEBYTECODE
export GEARBLOCKS_CACHE="$work/cache" PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_COMPILE=0
bin="$copy/.venv/bin"

step() {
    at=$1
    printf '\n== %s (%d s)\n' "$1" "$SECONDS"
}

# Begins a step beside others, on another core: `beside NAME COMMAND...`; `together` waits for all of them and shows what
# each of them said.
others=()
beside() {
    local begun=$SECONDS
    set -m # a group of its own, which can be ended as a whole
    {
        "${@:2}"
        echo "took $((SECONDS - begun)) s"
    } >"$work/beside ${#others[@]}" 2>&1 </dev/null &
    set +m
    others+=("$1")
    processes+=($!)
}
together() {
    local each code=0
    for each in "${!others[@]}"; do
        step "${others[each]}"
        wait "${processes[each]}" || code=$?
        cat "$work/beside $each"
        if [ "$code" -ne 0 ]; then exit "$code"; fi
    done
    others=()
    processes=()
}

# What this machine does not have is said at the end.
left_out() {
    echo "$1 is not here"
    echo "left out: $1" >>"$work/missing"
}

# The command that follows the mark <!-- command: NAME --> in the README.
readme_command() { awk -v mark="<!-- command: $1 -->" '$0 == mark { getline; getline; print; exit }' README.md; }

# Runs pytest's command and keeps its closing line, to be said again at the end.
tests() {
    local name=$1 log
    shift
    log=$(mktemp "$work/tests.XXXXXX")
    "$@" 2>&1 | tee "$log"
    printf '%s\n%s\n' "$name" "$(tail -n 1 "$log")" >>"$work/closing"
}

# The kernels of OpenBLAS can be chosen where numpy and scipy bring one with several; the names that they answer say whether
# they obeyed.
blas_kernels() {
    "$bin/python" - <<'PYTHON'
import ctypes
from pathlib import Path

import numpy
import scipy

for module in (numpy, scipy):
    root = Path(module.__file__).parent
    for library in [*root.parent.glob(f"{root.name}.libs/*openblas*"), *root.glob(".dylibs/*openblas*")]:
        loaded = ctypes.CDLL(str(library))
        for name in ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename", "openblas_get_corename"):
            if hasattr(loaded, name):
                answer = getattr(loaded, name)
                answer.restype = ctypes.c_char_p
                print(answer().decode())
PYTHON
}

# Whether the processor has all of these instructions; where it does not say so, it has none of them.
processor_has() {
    local flag
    for flag in "$@"; do
        grep -qsw -m 1 "$flag" /proc/cpuinfo || return 1
    done
}

# Those of numpy's loops for newer processors that are used here and begin with one of these words.
numpy_features() {
    "$bin/python" - "$@" <<'PYTHON'
import sys

try:
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
except ImportError:
    from numpy.core._multiarray_umath import __cpu_dispatch__, __cpu_features__

print(*(name for name in __cpu_dispatch__ if __cpu_features__.get(name) and name.startswith(tuple(sys.argv[1:]))))
PYTHON
}

# Every processor that can be had here: calls `$1 NAME COMMAND...` for each, COMMAND being what goes before a test command.
on_processors() {
    local each=$1 kernel instructions level without features before=
    for kernel in Haswell Zen SkylakeX; do
        instructions="avx2 fma"
        if [ "$kernel" = SkylakeX ]; then instructions="avx2 fma avx512f"; fi
        # shellcheck disable=SC2086
        if processor_has $instructions && OPENBLAS_CORETYPE=$kernel blas_kernels | grep -x "$kernel" >/dev/null; then
            "$each" "OpenBLAS for $kernel" env OPENBLAS_CORETYPE="$kernel"
        else
            left_out "OpenBLAS for $kernel"
        fi
    done
    for without in "AVX512 X86_V4" "AVX512 X86_V4 AVX2 FMA3 X86_V3"; do
        # shellcheck disable=SC2086
        features=$(numpy_features $without)
        if [ -n "$features" ] && [ "$features" != "$before" ]; then
            "$each" "numpy without $features" env NPY_DISABLE_CPU_FEATURES="$features"
        else
            left_out "numpy without $without"
        fi
        before=$features
    done
    for level in "x86-64-v2 ssse3 sse4_1 sse4_2 popcnt" "x86-64-v3 avx2 fma bmi2 movbe"; do
        # shellcheck disable=SC2086
        set -- $level
        if processor_has "${@:2}" && command -v cc >/dev/null && compiles_for "$1"; then
            "$each" "C for $1" env CC="cc -O3" GEARBLOCKS_VARIANT="$1"
        else
            left_out "C for $1"
        fi
    done
}

# Whether the C compiler knows an architecture.
compiles_for() { echo 'int main(void) { return 0; }' | cc "-march=$1" -x c - -o "$work/probe" 2>/dev/null; }

# How many tests pytest's closing lines count as `$1`.
counted() { { grep -oE "[0-9]+ $1\b" "$work/closing" || true; } | awk '{ sum += $1 } END { print sum + 0 }'; }

# The last words: what pytest said, what was left out, and all tests in one plain line.
finish() {
    step "all passed"
    cat "$work/closing"
    if [ -e "$work/missing" ]; then cat "$work/missing"; fi
    echo "$(counted passed) passed, $(counted failed) failed"
}
