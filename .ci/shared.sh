# What .ci/run and .ci/long begin with: a copy of the tracked and the new files, in a path with a blank and umlauts, with a
# cache of its own. Sourced in the root of the repository; afterwards the working directory is the copy.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
copy="$work/prüf stand"
mkdir -p "$copy"
git ls-files -co --exclude-standard -z | while IFS= read -r -d '' file; do
    if [ -e "$file" ]; then printf '%s\0' "$file"; fi
done | tar -c --null -T - | tar -x -C "$copy"
cd "$copy"
export GEARBLOCKS_CACHE="$work/cache" PIP_DISABLE_PIP_VERSION_CHECK=1
bin="$copy/.venv/bin"

step() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }

# What this machine does not have is said at the end.
missing=()
left_out() {
    echo "$1 is not here"
    missing+=("$1")
}

# The command that follows the mark <!-- command: NAME --> in the README.
readme_command() { awk -v mark="<!-- command: $1 -->" '$0 == mark { getline; getline; print; exit }' README.md; }

# Runs pytest's command and keeps its closing line, to be said again at the end.
closing=()
tests() {
    local name=$1
    shift
    "$@" 2>&1 | tee "$work/tests.txt"
    closing+=("$name: $(tail -n 1 "$work/tests.txt")")
}

# The last words: what pytest said, what was left out.
finish() {
    step "all passed"
    printf '%s\n' "${closing[@]}"
    if [ ${#missing[@]} -gt 0 ]; then printf 'left out: %s\n' "${missing[@]}"; fi
}
