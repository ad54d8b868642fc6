# Sourced by fly and test: the repository's own virtual environment, made on first use.
#
#   use_venv        installs the project into .venv with what the documentation shows, unless that was done
#   use_venv test   the same, with the tools that the tests need
#
# Sets $root (the repository), $venv, and $shown: the extras that its commands need. An
# installation is repeated when pyproject.toml has changed or the repository has moved. Two scripts
# at once wait for each other.

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
venv="$root/.venv"
shown="planners"

use_venv() {
    local extra="${1:-}"
    exec 9<"$root/pyproject.toml"
    if command -v flock >/dev/null && ! flock --nonblock 9; then
        echo "waiting until another script has installed .venv" >&2
        flock 9
    fi
    if ! is_installed "$extra"; then
        make_venv
        install_project "$extra"
    fi
    exec 9<&-
}

# The file that an installation leaves behind: what it was made from.
stamp_of() { echo "$venv/installed${1:+-$1}"; }

stamp() { echo "$root [$shown]" && cat "$root/pyproject.toml"; }

is_installed() { [[ -x "$venv/bin/companion" ]] && stamp | cmp -s - "$(stamp_of "$1")"; }

# Keeps a .venv that works here; one that was copied or moved along would run the other checkout.
make_venv() {
    local made_for="$root"
    [[ -f "$venv/root" ]] && made_for="$(<"$venv/root")"
    if [[ "$made_for" != "$root" ]] || ! "$venv/bin/python" -m pip --version &>/dev/null; then
        local python
        python="$(find_python)"
        "$python" -m venv --clear "$venv"
    fi
    echo "$root" >"$venv/root"
}

install_project() {
    echo "installing into $venv, which takes a minute or two" >&2
    "$venv/bin/python" -m pip install -qq --disable-pip-version-check \
        --editable "$root[$shown${1:+,$1}]" >&2
    local done_with
    for done_with in "" "$1"; do
        stamp >"$(stamp_of "$done_with")"
    done
}

# The first Python on the path that is new enough and can make virtual environments. Each is
# asked, because pyenv and others put commands on the path that only print an error.
find_python() {
    local python unfit="none was found"
    for python in python3 python3.14 python3.13 python3.12 python3.11 python; do
        if ! "$python" -c "import sys; sys.exit(sys.version_info < (3, 11))" 2>/dev/null; then
            continue
        elif "$python" -c "import ensurepip, venv" 2>/dev/null; then
            echo "$python"
            return
        fi
        unfit="$python has no venv module (on Debian and Ubuntu: apt install $python-venv)"
    done
    echo "Python 3.11 or newer is needed: $unfit" >&2
    return 1
}
