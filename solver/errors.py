"""What can go wrong, as two exceptions: the scene is wrong, or a step did not converge."""


class SceneError(ValueError):
    """The scene cannot be run. One line: which part, what was found, what was expected."""


class StepFailed(RuntimeError):
    """Cutting the increment back has ended. One line with the number and the remedy.

    results : Results up to the last converged increment, or None
    """

    def __init__(self, message, results=None):
        super().__init__(message)
        self.results = results
