"""One definition: records, validation and field lists all come from the pydantic models."""

import numpy as np
import pytest
from pydantic import BaseModel, ValidationError

from controller.errors import LayoutMismatch
from controller.schema.actuator import PRESETS
from controller.schema.layout import fields, from_record, layout_hash, record_dtype, require_same_layout, to_record
from controller.schema.messages import Command, Measurement, Telemetry
from controller.schema.modes import Law, Request
from controller.schema.parameters import Settings


def test_a_command_survives_the_way_through_its_record() -> None:
    settings = Settings(law=Law.FF_I, sensed=0b1000100000, K_P=(0.1, 0.2), u_open=(0.01, -0.02))
    command = Command(n=7, boot=2**62, request_n=3, request=Request.FOLLOW, target=(0.1, -0.2), settings=settings)
    assert from_record(Command, to_record(command)[0]) == command


def test_a_record_has_no_padding_and_survives_bytes() -> None:
    for model in (Command, Measurement, Telemetry):
        dtype = record_dtype(model)
        ends = [field.offset + np.dtype(field.type).itemsize * int(np.prod(field.shape)) for field in fields(model)]
        starts = [field.offset for field in fields(model)]
        assert starts == [0, *ends[:-1]]
        assert ends[-1] == dtype.itemsize


def test_field_list_reads_the_bytes_as_numpy_does() -> None:
    raw = to_record(Command(target=(0.25, -0.5), settings=Settings(K_I=(1.5, 2.5)))).tobytes()
    found = {field.name: field for field in fields(Command)}
    for name, expected in {"target": [0.25, -0.5], "settings.K_I": [1.5, 2.5]}.items():
        field = found[name]
        values = np.frombuffer(raw, field.type, int(np.prod(field.shape)), field.offset)
        assert values.tolist() == expected
    assert found["settings.K_I"].unit == "1/s"


def test_a_record_with_values_out_of_bounds_is_refused_by_name() -> None:
    record = to_record(Command())
    record["settings"]["K_P"] = 12.0
    with pytest.raises(ValidationError, match=r"settings\.K_P[\s\S]*less than or equal to 5"):
        from_record(Command, record[0])
    record = to_record(Command())
    record["target"] = np.nan
    with pytest.raises(ValidationError, match="target"):
        from_record(Command, record[0])


def test_layout_hash_follows_every_change_of_a_field() -> None:
    class One(BaseModel):
        a: int
        b: float

    class Two(BaseModel):
        a: float
        b: float

    assert layout_hash(One) != layout_hash(Two) != layout_hash(Two, One)
    with pytest.raises(LayoutMismatch, match="run the same version"):
        require_same_layout(layout_hash(One), layout_hash(Two))


def test_the_presets_are_the_table_of_the_paper() -> None:
    table = {name: (p.mass, p.length, max(p.k), min(p.k), max(p.b), min(p.b)) for name, p in PRESETS.items()}
    assert table == {
        "P1": (0.1250, 0.253, 75.1e-3, 75.1e-3, 0.167e-3, 0.167e-3),
        "P2": (0.1445, 0.253, 66.4e-3, 24.8e-3, 0.767e-3, 0.205e-3),
        "P3": (0.0922, 0.193, 99.8e-3, 99.8e-3, 0.132e-3, 0.132e-3),
    }
