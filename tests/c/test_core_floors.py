"""The C core stands on floors: a file includes and calls only what lies on lower ones."""

import re
from pathlib import Path

CORE = Path(__file__).parents[2] / "gearblocks" / "solver" / "c"

FLOORS: tuple[tuple[str, ...], ...] = (
    ("gb_sparse_ldu", "gb_report", "gb_stage_modes", "gb_implicit_angles", "gb_active_choice", "gb_raise"),
    ("gb_step_constraints", "gb_load_limit"),
    ("gb_force_split",),
    ("gb_inputs",),
    ("gb_time_terms",),
    ("gb_rest_share", "gb_limit_bend"),
    ("gb_rates",),
    (
        "gb_runge_kutta",
        "gb_rosenbrock",
        "gb_modes",
        "gb_constraint_state",
        "gb_memory",
        "gb_tolerance",
        "gb_turned_gears",
    ),
    ("gb_limit_noise", "gb_constraint_forces", "gb_force_noise"),
    ("gb_noise", "gb_flight"),
    (
        "gb_error_control",
        "gb_evaluate",
        "gb_impact",
        "gb_snapshot",
        "gb_follow",
    ),
    (
        "gb_angle_wrapping",
        "gb_lossy_gear",
        "gb_method_choice",
        "gb_point",
        "gb_step_matrix",
        "gb_massless_error",
        "gb_reach",
        "gb_rest",
        "gb_mode_search",
        "gb_exact_limit",
        "gb_dependence",
    ),
    ("gb_jump", "gb_progress"),
    ("gb_growth",),
    ("gb_give_up",),
    ("gb_dense_output", "gb_constraint_switching", "gb_limit_rest", "gb_limit_hold", "gb_limit_stay", "gb_grip"),
    ("gb_sliding", "gb_sliding_outputs", "gb_event_values", "gb_features"),
    ("gb_swings",),
    ("gb_locate_sampled", "gb_event", "gb_panel", "gb_force_enclosure", "gb_ledger", "gb_rounding_motion", "gb_defect"),
    ("gb_enclosed_limit",),
    ("gb_locate_enclosed", "gb_departure", "gb_departed", "gb_drift", "gb_cut"),
    ("gb_locate_polynomial", "gb_start"),
    ("gb_locate",),
    ("gb_account", "gb_record"),
    ("gb_step",),
    ("gb_quantity", "gb_watch", "gb_tangent_parameter"),
    ("gb_run", "gb_tangent_step"),
    ("gb_tangent_event",),
    ("gb_study", "gb_tangent_graze"),
    ("gb_tangents",),
)
"""From the ground up: a .c and its header each."""

ALONE = (
    "gb_model.h",
    "gb_core.h",
    "gb_patience.h",
    "gb_internal.h",
    "gb_methods.h",
    "gb_constraints.h",
    "gb_double_double.h",
    "gb_delassus.h",
    "gb_inline.h",
    "gb_gauss_jordan.h",
    "gb_coupled_bounds.h",
    "gb_lcp.h",
    "gb_loss.h",
    "gb_force_bounds.h",
    "gb_constraint_rows.h",
    "gb_active_set.h",
    "gb_mass.h",
    "gb_singular_balance.h",
    "gb_math.h",
    "gb_table.h",
    "gb_timed_crossing.h",
    "gb_enclosure.h",
    "gb_enclosed_table.h",
    "gb_vector.h",
    "gb_values_for.h",
    "gb_tangent_room.h",
    "gb_lane.h",
    "gb_lane_run.h",
)
"""Headers without a .c: every file may include them, they themselves those before them in this list."""

MAX_LINES, MAX_FUNCTION = 350, 60
FILES = sorted(path.name for path in CORE.glob("*.[ch]"))
FLOOR = {name: number for number, names in enumerate(FLOORS, 1) for name in names}


def _text(name: str) -> str:
    return (CORE / name).read_text(encoding="utf-8")


def _included(name: str) -> list[str]:
    return re.findall(r'^#include "([^"]+)"', _text(name), re.M)


def _code(name: str) -> str:
    """The text without comments and strings."""
    return re.sub(r'/\*.*?\*/|"(?:\\.|[^"\\])*"', " ", _text(name), flags=re.S)


def _functions(name: str) -> dict[str, int]:
    """Lines of every function that a file defines, by name."""
    found, lines = {}, _text(name).splitlines()
    for number, line in enumerate(lines):
        match = re.match(r"[A-Za-z][\w \*]*?\b(\w+)\(", line)
        if match and not line.startswith(("typedef", "#")):
            head = next(i for i in range(number, len(lines)) if lines[i].endswith(("{", ";")))
            if lines[head].endswith("{"):
                found[match[1]] = lines.index("}", head) - number + 1
    return found


DEFINED = {function: Path(name).stem for name in FILES if Path(name).stem in FLOOR for function in _functions(name)}


def test_every_file_of_the_core_has_one_place() -> None:
    placed = {f"{name}.{ending}" for name in FLOOR for ending in "ch"} | set(ALONE)
    assert placed - set(FILES) == {"gb_methods.h"}, "gb_methods.h is rendered, all others lie in the folder"
    assert set(FILES) <= placed, f"no floor: {sorted(set(FILES) - placed)}"
    assert sum(map(len, FLOORS)) == len(FLOOR)


def test_a_file_includes_its_own_header_and_lower_ones() -> None:
    for name in FILES:
        own = Path(name).stem
        if name in ALONE:
            lower = ALONE[: ALONE.index(name)]
            assert set(_included(name)) <= set(lower), f"{name} looks up"
            continue
        if name.endswith(".c"):
            assert _included(name)[0] == f"{own}.h", f"the header of {name} comes first, so that it stands by itself"
        for header in _included(name):
            stem = Path(header).stem
            assert header in ALONE or stem == own or FLOOR[stem] < FLOOR[own], f"{name} looks up to {header}"


def test_a_file_calls_only_what_lies_on_lower_floors() -> None:
    """gb_core.h declares functions of all floors: whoever includes it sees them, and must not use those above."""
    for name in FILES:
        if name.endswith(".h"):
            continue
        own = Path(name).stem
        called = set(re.findall(r"\b(gb_\w+)\(", _code(name))) & set(DEFINED)
        upward = {call: DEFINED[call] for call in called if DEFINED[call] != own and FLOOR[DEFINED[call]] >= FLOOR[own]}
        assert not upward, f"{name} calls upward"
        seen = {DEFINED[call] for call in called} - {own}
        included = {Path(header).stem for header in _included(name)} & set(FLOOR) - {own}
        assert included == seen, f"{name} includes what it calls, and nothing else"


def test_a_file_is_short_and_so_are_its_functions() -> None:
    assert [name for name in FILES if len(_text(name).splitlines()) > MAX_LINES] == []
    lengths = [(name, function, lines) for name in FILES for function, lines in _functions(name).items()]
    assert [x for x in lengths if x[-1] > MAX_FUNCTION] == []


def test_a_header_opens_with_what_it_is_and_knows_nothing_of() -> None:
    for name in FILES:
        if name.endswith(".h"):
            opening = re.match(r"/\*.*?\*/", _text(name), re.S)
            assert opening and " Knows " in opening[0], name
