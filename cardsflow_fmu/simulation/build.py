"""Builder of FMUs and .ssp files from an experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import write_files
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.cosim.signals.roles import ESTIMATOR, HARDWARE, ROLES, SENSORS
from cardsflow_fmu.experiment.config.table import validated
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.packed_files import require_packable
from cardsflow_fmu.experiment.settings.run import Compute
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.fmu.platforms import libraries_for
from cardsflow_fmu.fmu.writer import write_fmu
from cardsflow_fmu.models.by_role import C_MODELS, missing_in_c, model_class, model_in_c
from cardsflow_fmu.models.experiment_model import ExperimentModel
from cardsflow_fmu.models.plant import ContinuousPlantModel
from cardsflow_fmu.results.analysis.look_ahead import with_look_ahead
from cardsflow_fmu.runtime.library import find_platform, prebuilt_libraries, this_platform
from cardsflow_fmu.runtime.model_file import NativeModel
from cardsflow_fmu.simulation.reference_results import reference_results
from cardsflow_fmu.simulation.ssp.from_experiment import experiment_system, replace_plant
from cardsflow_fmu.simulation.ssp.writer import write_ssp
from cardsflow_fmu.utils.archive import read_contents
from cardsflow_fmu.utils.folder_lock import create_folder
from cardsflow_fmu.utils.temporary import temporary_folder

SYSTEM_FILE = "system.ssp"

Kind = Literal["cs", "me"]
"""Co-simulation, or model exchange."""

Libraries = Mapping[bool, Mapping[str, Path] | None]
"""C libraries of native and Python FMUs, by platform; None for the current platform."""


def build(
    experiment: Experiment,
    folder: str | Path,
    *,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    platforms: Sequence[str] | None = None,
    compute: Compute | None = None,
    kind: Kind = "cs",
    with_results: bool = False,
) -> dict[str, Path]:
    """Build plant.fmu, controller.fmu, reference.fmu, hardware.fmu and their system.ssp.

    For model exchange, build only plant.fmu: the other models are sampled. Robots with muscle laws
    have no hardware.fmu, because hardware is commanded with forces.

    Args:
        fmi: FMI version of the FMUs; the .ssp contains FMUs of FMI 2.0.
        arrays: Whether FMUs of FMI 3.0 have arrays.
        platforms: Platforms of the FMUs, such as `linux64` (default: the current platform; native
            FMUs also all platforms with a library in the package). Others need the extra `cross`.
        compute: `c` for FMUs in C, which run without Python; hardware.fmu, a Python model, is
            omitted. `python` for models that a Python process hosts (default: `run.compute`, with
            Python for models without a C version).
        kind: `cs` for co-simulation, `me` for model exchange.
        with_results: Whether FMUs contain reference results; hardware.fmu does not.

    Returns:
        The FMUs by model name; the .ssp is in the same folder.

    Raises:
        InputError: The folder cannot be written, an external FMU does not match or may not be
            packed, `compute` is `c` and a model has no C version, or model exchange does not
            support the plant.
    """
    is_continuous = validated(Kind, kind, "kind") == "me"
    native: bool | None = validated(Compute, compute or experiment.run.compute, "compute") == "c"
    if is_continuous:
        _require_continuous(experiment, compute)
        names, native = ["plant"], True
    else:
        experiment = with_look_ahead(experiment)
        if compute is None and native:
            native = None
        for fmu in experiment.fmus.values():
            require_packable(fmu.file, experiment.roots, fmu.key)
        names = [name for name in _model_names(experiment) if name in C_MODELS or not native]
    with temporary_folder() as scratch:
        kinds = {is_native(experiment, name, native) for name in names}
        libraries: Libraries = {kind: _libraries(platforms, scratch, kind) for kind in kinds}
        if fmi == "2.0" and platforms is None:
            libraries = _fmi_2_libraries(libraries)
        files = inner = build_fmus(
            *(experiment, scratch, names, fmi, arrays, libraries, native),
            with_results=with_results,
            is_continuous=is_continuous,
        )
        paths = list(files.values())
        if not is_continuous:
            if fmi != "2.0":
                (scratch / "inner").mkdir()
                libraries = _fmi_2_libraries(libraries)
                inner = build_fmus(
                    *(experiment, scratch / "inner", names, "2.0", arrays, libraries, native),
                    with_results=with_results,
                )
            paths.append(_build_system(experiment, inner, scratch))
        contents = {path.name: read_contents(path) for path in paths}
    with create_folder(Path(folder), "build"):
        written = write_files(folder, contents)
    return dict(zip(files, written[: len(files)], strict=True))


def _require_continuous(experiment: Experiment, compute: Compute | None) -> None:
    """Check that model exchange supports the plant of an experiment."""
    python = "models in Python" if compute == "python" else None
    unsupported = python or ContinuousPlantModel.missing(experiment)
    if "plant" in experiment.fmus:
        unsupported = "an external plant"
    if unsupported is not None:
        problem = f"model exchange does not support {unsupported}; build it for co-simulation"
        raise InputError(problem, file=experiment.file)


def _model_names(experiment: Experiment) -> list[str]:
    """Return the names of all models; without hardware for robots with muscle laws."""
    names = list(ROLES) if experiment.estimator is None else [*ROLES, SENSORS, ESTIMATOR]
    return names if modelled_muscles(experiment.robot) else [*names, HARDWARE]


def is_native(experiment: Experiment, name: str, native: bool | None) -> bool:
    """Return whether a model is built in C."""
    return missing_in_c(experiment, name) is None if native is None else native


def _libraries(
    platforms: Sequence[str] | None, folder: Path, native: bool
) -> dict[str, Path] | None:
    """Return the libraries of platforms; None for all prebuilt platforms."""
    folder = folder / f"libraries_{'native' if native else 'python'}"
    folder.mkdir()
    if platforms is not None:
        return libraries_for(platforms, folder, native=native)
    if not native:
        return None
    return libraries_for([this_platform().tuple, *prebuilt_libraries()], folder, native=True)


def _fmi_2_libraries(libraries: Libraries) -> Libraries:
    """Return the libraries of platforms that FMI 2.0 supports."""
    return {
        kind: files and {name: file for name, file in files.items() if find_platform(name).fmi2}
        for kind, files in libraries.items()
    }


def build_fmus(
    experiment: Experiment,
    folder: Path,
    names: Sequence[str],
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    libraries: Libraries | None = None,
    native: bool | None = None,
    sources: bool = True,
    with_results: bool = False,
    is_continuous: bool = False,
) -> dict[str, Path]:
    """Build all FMUs except external ones in an existing folder; return them by model name.

    `is_continuous` selects the plant for model exchange.
    """
    models = _models(experiment, names, native, is_continuous=is_continuous)
    resources, files = experiment_resources(experiment), {}
    period, run = experiment.controller.period, experiment.run
    divisors = {"controller": period, "plant": experiment.plant.step, HARDWARE: run.step}
    for name, (model, in_c) in models.items():
        step = period if name == "controller" else run.step
        results = None
        if with_results and name != HARDWARE:
            results = reference_results(experiment, name, step, is_continuous=is_continuous)
        files[name] = write_fmu(
            folder / f"{name}.fmu",
            model_class=model,
            model_name=name,
            ports=model.table(experiment),
            resources=experiment_resources(experiment, with_hardware=True)
            if name == HARDWARE
            else resources,
            step=step,
            stop_time=run.duration,
            internal_step=None if is_continuous else divisors.get(name),
            fmi=fmi,
            arrays=arrays,
            libraries=(libraries or {}).get(in_c is not None),
            native=in_c,
            dependencies=model.dependencies(experiment),
            sources=sources,
            is_continuous=is_continuous,
            about=experiment.about.model_dump(),
            results=results,
        )
    return files


def _models(
    experiment: Experiment, names: Sequence[str], native: bool | None, *, is_continuous: bool
) -> dict[str, tuple[type[ExperimentModel], NativeModel | None]]:
    """Return class and C model of each model without external FMU; None if it is in Python."""
    names = [name for name in names if name not in experiment.fmus]
    if is_continuous:
        model = ContinuousPlantModel
        in_c = NativeModel(model.file(experiment), has_derivatives=True)
        return dict.fromkeys(names, (model, in_c))
    return {name: (model_class(name), model_in_c(experiment, name, native)) for name in names}


def _build_system(experiment: Experiment, fmus: Mapping[str, Path], folder: Path) -> Path:
    """Build the .ssp from FMI 2.0 FMUs with scalars and external FMUs."""
    tables = {name: model_class(name).table(experiment) for name in _model_names(experiment)}
    files = {**fmus} | {name: fmu.file for name, fmu in experiment.fmus.items()}
    system = experiment_system(experiment, files, tables)
    sources = {f"resources/{name}.fmu": file for name, file in files.items()}
    variants = {}
    if HARDWARE in files:
        variants[HARDWARE] = replace_plant(system, f"resources/{HARDWARE}.fmu")
    return write_ssp(folder / SYSTEM_FILE, system, sources, variants)
