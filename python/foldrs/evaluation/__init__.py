"""How good the method is: the measures of the paper's Tables 1 and 2 over scenes of known truth (section 4).

One module a step: :mod:`~foldrs.evaluation.scenes` (ground truth), :mod:`~foldrs.evaluation.virtual`
(templates folded virtually), :mod:`~foldrs.evaluation.kinds` (landmark order and symmetries of a kind),
:mod:`~foldrs.evaluation.landmarked` and :mod:`~foldrs.evaluation.axes` (true axes carried onto templates),
:mod:`~foldrs.evaluation.geometry` (overlaps), :mod:`~foldrs.evaluation.measures` (one scene),
:mod:`~foldrs.evaluation.search` (what the search misses), :mod:`~foldrs.evaluation.run` (the protocols),
:mod:`~foldrs.evaluation.tables` (means over many), :mod:`~foldrs.evaluation.reliability` (whether
probabilities mean what they say) and :mod:`~foldrs.evaluation.report` (how they are shown and written).

The geometry is shapely's, not the compiled module's: a yardstick shares no code with what it measures.
"""

from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.measures import SceneMeasures, failed, measure
from foldrs.evaluation.report import TextTable, print_tables, text_tables, write_csv, write_json
from foldrs.evaluation.run import PROTOCOLS, Evaluation, Protocol, run_all
from foldrs.evaluation.scenes import Scene, TrueLandmark, load_scenes
from foldrs.evaluation.tables import Summary, summary, table
from foldrs.evaluation.virtual import virtual_scenes

__all__ = [
    "PROTOCOLS",
    "Evaluation",
    "Kind",
    "Protocol",
    "Scene",
    "SceneMeasures",
    "Summary",
    "TextTable",
    "TrueLandmark",
    "failed",
    "load_scenes",
    "measure",
    "print_tables",
    "run_all",
    "summary",
    "table",
    "text_tables",
    "virtual_scenes",
    "write_csv",
    "write_json",
]
