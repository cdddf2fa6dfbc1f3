#!/usr/bin/env python3
"""Doxygen's input filter: the headers have plain comments; here they become documentation, on standard output.

    tools/docs/header_comments.py include/slipdisk/model.h

- the comment at the top, "model.h: ...", is that of the file;
- a comment on lines of its own belongs to the declaration that follows, one behind a declaration to this one;
- rules ("--- building ---") begin a group of functions;
- rows X(name, "unit", "meaning", ...) of a table of members are written out as members.
"""
import pathlib
import re
import sys

COMMENT = re.compile(r"/\*(?!\*).*?\*/", re.S)
RULE = re.compile(r"^/\* --- (.*?) -+ \*/$")
ROW = re.compile(r'\bX\((\w+), "(.*?)",\s*(?:\\\n\s*)?"(.*?)"(?:, \w+)?\)')
TABLE = re.compile(r"^/\* X\((?:.*\n)*?(?=typedef)", re.M)
FUNCTION = re.compile(r"^SD_API [^;(]*?\b(sd_\w+)\(", re.M)
SEVERAL = re.compile(r"^(\s*)((?:const )?\w+) ([^;()]*,[^;()]*);\s*$")


def body_of(comment, functions):
    """The text of a comment; behind the names of functions stand brackets, of which Doxygen makes links."""
    body = "\n".join(re.sub(r"^\s*\* ?", "", line) for line in comment[2:-2].strip().splitlines())
    body = re.sub(r"`([^`<>]+)`", r"<tt>\1</tt>", body)
    body = re.sub(r"\b(SD_[A-Z]+\()", r"%\1", body)  # no links to macros with arguments: Sphinx cannot read these
    return re.sub(r"\bsd_\w+\b(?!\()", lambda name: name[0] + "()" * (name[0] in functions), body)


def marked(text, functions):
    """The text with its comments marked as documentation."""
    out, at, group = [], 0, False
    for found in COMMENT.finditer(text):
        between = text[at:found.start()]
        line = (between if "\n" in between else "").rpartition("\n")[2]
        body, rule = body_of(found.group(), functions), RULE.match(found.group())
        at = found.end()
        if found.start() == 0:
            name, _, rest = body.partition(": ")
            out.append(f"/** @file {name}\n{rest[:1].upper()}{rest[1:]} */")
        elif rule:
            out += [between, "/** @} */\n" if group else "", f"/** @name {rule[1][:1].upper()}{rule[1][1:]}\n@{{ */"]
            group = True
        elif not line.strip():
            out += [between, f"/** {body} */"]
        else:
            # A comment behind several members is that of each.
            several = SEVERAL.match(line)
            if several:
                space, kind, names = several.groups()
                out += [between[:len(between) - len(line)],
                        *(f"{space}{kind} {name.strip()}; /**< {body} */\n" for name in names.split(","))]
            else:
                out += [between, f"/**< {body} */"]
    rest = text[at:]
    if group:
        head, guard, tail = rest.rpartition("#ifdef __cplusplus")
        rest = f"{head}/** @}} */\n{guard}{tail}"
    return "".join(out) + rest


def main():
    path = pathlib.Path(sys.argv[1])
    functions = {name for header in path.parent.glob("*.h") for name in FUNCTION.findall(header.read_text())}
    text = path.read_text()
    rows = "".join(f"double {name}; /**< {meaning}; unit: {unit} */\n" for name, unit, meaning in ROW.findall(text))
    text = TABLE.sub("", text)
    sys.stdout.write(marked(text, functions).replace("SD_CONTACT_RECORD(SD_CONTACT_MEMBER)", rows))


if __name__ == "__main__":
    main()
