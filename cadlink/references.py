"""Files a STEP file refers to: parts of an assembly may be files of their own. Runs in the reading process only."""

import os

from OCP.StepBasic import StepBasic_DocumentFile

STEP_ENDINGS = (".stp", ".step", ".p21")


def missing_references(model, path):
    """Names of STEP files that a STEP file refers to and that are not there.

    A relative name is looked for beside the file that names it, an absolute one where it says.
    model : the reader's model of `path`
    """
    folder = os.path.dirname(os.path.abspath(path))
    found = []
    for i in range(1, model.NbEntities() + 1):
        entity = model.Value(i)
        if not isinstance(entity, StepBasic_DocumentFile) or entity.Id() is None:
            continue
        name = entity.Id().ToCString().strip()
        if name.lower().endswith(STEP_ENDINGS) and not os.path.exists(os.path.join(folder, name)):
            found.append(name)
    return list(dict.fromkeys(found))
