"""Every key of a scenario is explained where it is read: the documentation is made from that."""

import typing

import pytest
from pydantic import BaseModel

from it2hys.experiments.scenario import Scenario
from it2hys.sweeps.schema import CsvArguments, SweepScenario


def models_of(annotation):
    """Yield the models that an annotation is made of, and those within them."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        for field in annotation.model_fields.values():
            yield from models_of(field.annotation)
    for argument in typing.get_args(annotation):
        yield from models_of(argument)


MODELS = sorted(
    {m for scenario in (Scenario, SweepScenario, CsvArguments) for m in models_of(scenario)},
    key=lambda model: model.__name__,
)


def test_the_tables_of_both_kinds_are_found():
    names = {model.__name__ for model in MODELS}
    assert {"RecordEntry", "StandEntry", "NextEntry", "Fmu", "Vary", "Intervals", "Metric"} <= names


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_key_is_explained(model):
    for name, field in model.model_fields.items():
        if field.init is not False and field.annotation is not type(None):
            assert field.description and field.description.endswith("."), name
