"""`documentation/` of an FMU: equations, timing convention, parameters, licence."""

from importlib.resources import files

from jinja2 import Environment, PackageLoader

from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.model.effect import Effect
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, READING
from it2hys.model.variables import Variable, load_table


def documentation_files(
    model: str, parameters: ParameterSet, licence: bytes, fmi: int = 2
) -> dict[str, bytes]:
    """Return the files of `documentation/` by their path in the FMU."""
    variables = load_table().of_model(model, parameters.counts)
    page = render(
        "documentation.html",
        model=model,
        fmi=fmi,
        identifier=IDENTIFIERS[model],
        parameters=parameters,
        before=_words(BEFORE_CORE),
        behind=_words(BEHIND_CORE),
        reading=_words(READING),
        signals=[v for v in variables if v.causality != "parameter"],
        scalars=[_row(v, parameters) for v in variables if v.causality == "parameter"],
    )
    timing = files("it2hys.fmu") / "templates" / "timing.svg"
    return {
        "documentation/index.html": page.encode(),
        "documentation/timing.svg": timing.read_bytes(),
        "documentation/licenses/license.txt": licence,
    }


def render(template: str, **values: object) -> str:
    """Return a page of the package's templates, filled in."""
    environment = Environment(
        loader=PackageLoader("it2hys.fmu"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template(template).render(**values)


def _words(effects: dict[str, Effect]) -> list[str]:
    return [effect.words or name for name, effect in effects.items()]


def _row(variable: Variable, parameters: ParameterSet) -> dict:
    """Return a parameter as people read it: lengths in um."""
    value, unit = parameters[variable.name], variable.type.unit or ""
    if variable.type.displayUnit in ("um", "um/V"):
        value, unit = value * 1e6, variable.type.displayUnit.replace("u", "µ", 1)
    return {
        "name": variable.name,
        "value": f"{value:.6g}",
        "unit": unit,
        "text": variable.description,
    }
