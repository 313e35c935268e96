"""Which runs the study of learning makes, and what it says of them."""

from learning import LEGS, RIGHT, SETUPS, Case, cases, learnt_table, time_table


def row(case, leg_times, learnt=None):
    told = {} if learnt is None else {"learnt": learnt}
    return {"case": list(case), "legs": [{"time": time, **told} for time in leg_times]}


def test_a_right_belief_is_not_told_and_a_drawn_robot_drives_in_one_world_of_each_family():
    made = list(cases(["doubled", "right", "drawn 3"], 2, "pymunk"))
    assert len(made) == 2 * 2 * 3 + 2 * 2 * 2 + 2 * 3
    assert len(set(made)) == len(made)
    drawn = SETUPS["drawn 3"].drive.max_acceleration
    assert {case.settings(SETUPS[case.setup].drive).robot.max_acceleration for case in made} == {0.75, 1.5, drawn}


def test_savings_are_of_the_legs_from_the_third_on_and_an_unended_run_counts_in_none():
    modes = {"off": 8.0, "on": 6.0, "told": 5.0}
    rows = [
        row(Case("doubled", "u", world, mode, "pymunk"), [9.0, 9.0] + [time] * (LEGS - 2))
        for mode, time in modes.items()
        for world in (0, 1)
    ]
    rows.append(row(Case("doubled", "u", 2, "off", "pymunk"), [9.0]))
    (line,) = [line for line in time_table(rows).splitlines() if line.startswith("| doubled")]
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[2:6] == ["3", "9.00 / 9.00 / 8.00 (1 not)", "9.00 / 9.00 / 6.00", "9.00 / 9.00 / 5.00"]
    assert cells[6:] == ["25.0 +- 0.0", "37.5 +- 0.0", "-20.0 +- 0.0"]


def test_errors_and_coverage_are_of_the_truth():
    exact = [[value, 0.9 * value, 1.1 * value] for value in RIGHT]
    wide = [[1.1 * RIGHT.max_acceleration, 1.0, 2.0], [0.2, 0.15, 0.25], [0.01, 0.005, 0.02]]
    rows = [row(Case("right", "u", k, "on", "pymunk"), [3.0], learnt) for k, learnt in enumerate((exact, wide))]
    (line,) = [line for line in learnt_table(rows).splitlines() if line.startswith("| set-ups | 1")]
    assert line == "| set-ups | 1 | 2 | 6.7, 9.5; 1.00 | 49.0, 69.3; 0.50 | 7.1, 10.0; 0.50 |"
