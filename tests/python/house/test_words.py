"""Words with a standard term: the private noun stands in no identifier, and the rarest in no comment either."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
# Private noun to the standard term.
NOUNS = {
    "wish": "request", "wishes": "requests", "wished": "requested", "deed": "action", "deeds": "actions",
    "blur": "uncertainty", "blurred": "uncertain", "rubbing": "mechanical loss", "told": "reported, estimated",
}  # fmt: skip
# Parts of ordinary compounds (`under_way`), private only when they stand alone.
ALONE = {"way": "travel, path", "ways": "paths", "Leave": "step limit", "led_back": "reversed"}
PLACES = (("crates", "src/**/*.rs"), ("python/hydrocrane", "**/*.py"), ("cockpit/src", "**/*.ts"))
TEXT = {
    ".rs": (r"//.*", r"""'"'|"(?:[^"\\]|\\(?s:.))*\""""),
    ".py": (r"#.*", r'"""(?s:.*?)"""|"(?:[^"\\\n]|\\.)*"'),
    ".ts": (r"//.*|/\*(?s:.*?)\*/", r'"(?:[^"\\\n]|\\.)*"|`(?s:(?:[^`\\]|\\.)*)`'),
}


def files() -> list[Path]:
    crates = [path for crate in sorted((ROOT / "crates").iterdir()) for path in crate.glob("src/**/*.rs")]
    found = [path for folder, pattern in PLACES[1:] for path in (ROOT / folder).glob(pattern)]
    return sorted(crates + found)


def parts(identifier: str) -> list[str]:
    """`told_sinking` and `toldSinking` as their words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", identifier).lower().split("_")


@pytest.mark.parametrize("path", files(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_standard_terms_stand_for_private_nouns(path):
    comment, quoted = TEXT[path.suffix]
    text = path.read_text(encoding="utf-8")
    code = re.sub(f"{quoted}|{comment}", " ", text)
    # The browser's own method.
    code = code.replace(".blur()", "") if path.suffix == ".ts" else code
    for identifier in set(re.findall(r"[A-Za-z_]\w*", code)):
        term = ALONE.get(identifier) or next((NOUNS[word] for word in parts(identifier) if word in NOUNS), None)
        assert term is None, f"`{identifier}`: write {term}"
    comments = " ".join(re.findall(f"{comment}|(?:{quoted})" if path.suffix == ".py" else comment, text))
    words = re.findall(r"\b(?:wish(?:es|ed)?|deeds?|rubbing|led back)\b", comments)
    assert not words, f"a comment says {words[0]}"
