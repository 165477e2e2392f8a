"""Files a STEP file refers to: parts of an assembly may be files of their own. Runs in the reading process only."""

import os

from OCP.IFSelect import IFSelect_RetDone
from OCP.StepBasic import StepBasic_DocumentFile
from OCP.STEPControl import STEPControl_Reader

STEP_ENDINGS = (".stp", ".step", ".p21")


def wrong_references(model, path):
    """One line about STEP files that a STEP file, or one it refers to, names and that cannot be read; "" for none.

    A relative name is looked for beside the file that names it, an absolute one where it says. OpenCASCADE would leave
    such parts out in silence, and follow a file that refers to itself without end.
    model : the reader's model of `path`
    """
    missing, unread, round_about = [], [], []
    look_into(model, os.path.abspath(path), (os.path.abspath(path),), set(), missing, unread, round_about)
    if missing:
        return f"it refers to {listed(missing)}, not found: expected beside it, or where an absolute path says"
    if unread:
        return f"it refers to {listed(unread)}, which OpenCASCADE cannot parse"
    if round_about:
        return f"it refers to {listed(round_about)}, which refers back to it"
    return ""


def look_into(model, path, above, known, missing, unread, round_about):
    """Append to the lists what is wrong with the references of a model, and with those of the files it refers to.

    above : files on the way to this one, itself included; known : files looked into before
    """
    for name in references(model):
        file = os.path.join(os.path.dirname(path), name)
        same = [other for other in above if os.path.exists(file) and os.path.samefile(file, other)]
        if not os.path.exists(file):
            missing.append(name)
        elif same:
            round_about.append(name)
        elif os.path.realpath(file) not in known:
            known.add(os.path.realpath(file))
            reader = STEPControl_Reader()
            if reader.ReadFile(file) != IFSelect_RetDone:
                unread.append(name)
            else:
                look_into(reader.WS().Model(), file, (*above, file), known, missing, unread, round_about)


def references(model):
    """Names of the STEP files that a model refers to."""
    entities = (model.Value(i) for i in range(1, model.NbEntities() + 1))
    documents = [e for e in entities if isinstance(e, StepBasic_DocumentFile) and e.Id() is not None]
    return [name for e in documents if (name := e.Id().ToCString().strip()).lower().endswith(STEP_ENDINGS)]


def listed(names):
    return ", ".join(dict.fromkeys(names))
