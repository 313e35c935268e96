"""Names in a sentence of bringup."""

import pytest

from collplan_ros.bringup.words import in_words


@pytest.mark.parametrize(
    ("names", "sentence"), [(["a"], "a"), (["a", "b"], "a and b"), (["a", "b", "c"], "a, b and c")]
)
def test_names_in_a_sentence(names, sentence):
    assert in_words(names) == sentence
