# SPDX-License-Identifier: Apache-2.0
"""The node's printed descriptions match its behaviour."""

import json
import math

import canopen
import cantools
import pytest

from axis import RATED_NM
from device import NODE_ID


@pytest.fixture
def dbc(descriptions):
    return cantools.database.load_file(str(descriptions / "trackservo.dbc"), strict=True)


def test_eds_loads_without_a_warning(descriptions, caplog):
    dictionary = canopen.import_od(str(descriptions / "trackservo.eds"), NODE_ID)
    assert caplog.records == []
    assert dictionary["Pitch Controlword"].index == 0x6840


def test_the_description_that_servoctl_carries_is_the_same_for_every_commit(descriptions, node):
    text = (descriptions / "parameters.json").read_text()
    assert node.sdo[0x3030][3].raw not in text
    fixed = [row for row in json.loads(text)["objects"] if row["type"] == "VISIBLE_STRING" and row["access"] == "const"]
    assert len(fixed) > 3 and not any("default" in row for row in fixed)
