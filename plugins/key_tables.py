"""What every table of a scene file has in common: known keys only, and choices of one key out of several."""

from pydantic import BaseModel, ConfigDict

from .quantities import shown, wrong


class Table(BaseModel):
    """A table of the file: no key but those named."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class OrText:
    """In the JSON schema, beside a table: the texts that a validator takes in its place.

    texts : function that returns them
    """

    def __init__(self, texts):
        self.texts = texts

    def __get_pydantic_json_schema__(self, schema, handler):
        return {"anyOf": [handler(schema), {"enum": list(self.texts())}]}


def one_of(value, keys, expected):
    """A table that holds exactly one of some keys; misspelt ones are left to the check for unknown keys."""
    found = [key for key in keys if isinstance(value, dict) and key in value]
    misspelt = isinstance(value, dict) and not set(value) <= set(keys)
    if len(found) == 1 or (misspelt and not found):
        return value
    raise wrong(" and ".join(found) or shown(value), f"{expected}, one of {', '.join(keys)}")
