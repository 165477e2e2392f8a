"""What goes wrong with a CAD file, in one line that a forming engineer can act on."""


class CadError(ValueError):
    """Wrong CAD input: the line names the file, the part, what was found and what was expected."""


class UnknownPart(CadError, KeyError):
    """A part name that the assembly does not have; the line lists the names that exist."""

    def __str__(self):
        return self.args[0]
