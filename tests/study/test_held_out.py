"""Seeded worlds in the study: ranges of seeds for each family, and which are held out."""

import pytest

from collplan_core.worlds.families import FAMILIES
from collplan_study.question import held_out
from collplan_study.question.sources import load_sources


@pytest.mark.parametrize("family", FAMILIES)
def test_a_range_of_seeds_is_as_many_worlds_of_the_family(family):
    sources = load_sources((f"{family}:0-23",), None, None)
    assert [source.world.name for source in sources] == [f"{family}:{seed}" for seed in range(24)]
    assert {source.family for source in sources} == {family}


LATER = {"posts"}
"""Families that were not there yet when the held-out worlds were committed."""


def test_worlds_of_every_family_are_held_out():
    assert {*held_out.FAMILIES, *held_out.FURTHER_FAMILIES} == {*FAMILIES} - LATER
