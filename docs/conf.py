"""Sphinx: the documentation site from the pages of this folder. `tools/docs.sh` builds it.

The pages are plain Markdown that also reads well where no site is built: links among them are those of files, and
formulas stand between dollar signs. Sphinx adds navigation, search and the interfaces of the headers (Doxygen, Breathe)
and of the Python package (autodoc). Nothing is loaded from the network: formulas are set by the KaTeX of the distribution.
"""
import os
import pathlib
import re
import shutil
import sys

from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx import addnodes
from sphinx.util.nodes import make_refnode

DOCS = pathlib.Path(__file__).resolve().parent
ROOT = DOCS.parent
JAVASCRIPT = pathlib.Path("/usr/share/javascript")
PLAY = pathlib.Path(os.environ.get("SLIPDISK_PLAY", ROOT / "build/play"))  # pages of tools/play.sh
KATEX = JAVASCRIPT / "katex"
KATEX_LICENCE = pathlib.Path("/usr/share/doc/libjs-katex/copyright")
NORMALIZE_IMPORT = "@import url(/javascript/normalize.css/normalize.css);"
GUMSHOE_IMPORT = 'import Gumshoe from "./gumshoe-patched.js";'
DARK_COLOURS = re.compile(r'body\[data-theme="dark"\] \{([^}]*)\}')
sys.path[:0] = [str(ROOT / "tools/python"), str(ROOT / "tools/docs")]
import names  # noqa: E402

project = "slipdisk"
author = "the slipdisk authors"
release = version = re.search(r'SD_VERSION "([^"]*)"', (ROOT / "include/slipdisk/version.h").read_text())[1]
language = "en"

extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx_copybutton"]
exclude_patterns = ["figures", "studies/figures", "paper"]
default_role = "code"  # `x` in a docstring
highlight_language = "none"  # a block without a language is a deck or what a program prints
suppress_warnings = ["myst.header"]  # pages may leave out a level of headings

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
myst_dmath_allow_labels = False
myst_update_mathjax = False

breathe_projects = {"slipdisk": os.environ.get("SLIPDISK_DOXYGEN_XML", str(ROOT / "build/docs/doxygen/xml"))}
breathe_default_project = "slipdisk"
breathe_domain_by_extension = {"h": "c"}
breathe_show_include = False

# Types of the C library, and of numpy, which have no page here.
nitpick_ignore_regex = [("c:identifier", r"u?int\d+_t|size_t|FILE|va_list"), ("py:.*", r".*")]

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}  # else all that it stands for
add_module_names = False

copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True

smartquotes = False

html_theme = "furo"
html_title = f"slipdisk {release}"
html_static_path = ["../tools/docs/static"]
html_css_files = ["site.css"]
html_favicon = "../tools/docs/static/icon.svg"
html_copy_source = False
html_show_copyright = html_show_sphinx = False
html_show_search_summary = False  # a page that is opened as a file may not read others
html_theme_options = {"sidebar_hide_name": False, "top_of_page_button": None,
                      "light_logo": "icon.svg", "dark_logo": "icon.svg"}
mathjax_path = "katex/katex.min.js"  # Sphinx's own hook for formulas, which it writes as \(...\) and \[...\]
mathjax_options = {"defer": "defer"}


def resolve_header(app, env, node, contnode):
    """A struct, a function or a header that Doxygen has found in a comment: Breathe makes no targets of their names."""
    if node.get("reftype") != "ref":
        return None
    target = node["reftarget"]
    if target.startswith("struct"):
        name = target[len("struct"):].replace("__", "_")
        return env.get_domain("c").resolve_xref(env, node["refdoc"], app.builder, "struct", name, node, contnode)
    if re.match(r"\w+_8h_1", target):
        name = contnode.astext().removesuffix("()")
        return env.get_domain("c").resolve_xref(env, node["refdoc"], app.builder, "func", name, node, contnode)
    if target.endswith("_8h"):
        return make_refnode(app.builder, node["refdoc"], f"api/{target[:-3]}", None, contnode)
    return None


def name_pages(app, doctree, docname):
    """Links whose text is the name of a file, as they read well without a site, have the title of the page here."""
    for link in doctree.findall(nodes.reference):
        target = pathlib.PurePosixPath(docname).parent / link.get("refuri", "").split("#")[0]
        page = os.path.normpath(target).removesuffix(app.builder.out_suffix) if app.builder.format == "html" else ""
        if page in app.env.titles and re.fullmatch(r"[\w/.]+\.md", link.astext()):
            link.children = [nodes.inline(text=app.env.titles[page].astext())]


def fill_names(app, docname, source):
    """The lists of names.md, from the program."""
    if docname == "names":
        source[0] = names.fill(source[0])


def play_pages():
    return sorted(PLAY.glob("*.html"))


def link_pages(app, docname, source):
    """Links to the pages with the engine, if there are any; they are part of the site then."""
    if docname == "play" and play_pages() and app.builder.format == "html":
        links = " ".join(f'<a href="play/{page.name}">{page.stem.capitalize()}</a>' for page in play_pages())
        source[0] = source[0].replace("<!-- pages -->", f"<p>Here: {links}</p>")


def copy_pages(app):
    for page in play_pages():
        folder = pathlib.Path(app.outdir) / "play"
        folder.mkdir(exist_ok=True)
        shutil.copy(page, folder / page.name)


def note_keys(app, doctree):
    """Every key in the tables of deck.md is something that the search finds by itself: "materials.k_n (deck key)"."""
    if app.env.docname != "deck":
        return
    for table in doctree.findall(nodes.table):
        rows = list(table.findall(nodes.row))
        if rows[0].astext().split()[:2] != ["key", "type"]:
            continue
        group = table.parent.next_node(nodes.title).astext()
        for row in rows[1:]:
            cell = row.next_node(nodes.paragraph)
            name = cell.astext() if group == "deck" else f"{group}.{cell.astext()}"
            cell["ids"].append(f"key-{name}")
            app.env.get_domain("std").note_object("key", name, f"key-{name}", location=cell)


def note_words(app, doctree):
    """Every word in the tables of the glossary, too: "rattler (word)" leads to its row."""
    if app.env.docname != "glossary":
        return
    for table in doctree.findall(nodes.table):
        rows = list(table.findall(nodes.row))
        if rows[0].next_node(nodes.entry).astext() != "word":
            continue
        for row in rows[1:]:
            cell = row.next_node(nodes.paragraph)
            for word in cell.astext().split(", "):
                place = "word-" + re.sub(r"\W+", "-", word.lower())
                cell["ids"].append(place)
                app.env.get_domain("std").note_object("word", word, place, location=cell)


def other_words():
    """{page: [(word, anchor)]} of the table "Other words" of the glossary: the first link of a row is where its words lead."""
    found = {}
    section = (DOCS / "glossary.md").read_text().split("\n## Other words\n")[1].split("\n## ")[0]
    for words, page, anchor in re.findall(r"^\| ([^|]+) \|.*?\]\(([\w/]+)\.md(?:#([\w-]+))?\)", section, re.M):
        found.setdefault(page, []).extend((word, anchor) for word in words.split(", "))
    return found


OTHER_WORDS = other_words()


def note_other_words(app, doctree):
    """The search finds the page of such a word first, whatever words the page itself uses."""
    entries = [("single", word, anchor, "", None) for word, anchor in OTHER_WORDS.get(app.env.docname, [])]
    if entries:
        doctree.insert(0, addnodes.index(entries=entries))


def columns_to_fields(app, what, name, thing, options, lines):
    """Lines of a docstring such as "deck    path of a deck" become a list of fields. Pages introduce modules themselves."""
    if what == "module":
        lines.clear()
    column = re.compile(r"^(\w[\w, ]*?)\s{2,}(\S.*)$")
    for k, line in enumerate(lines):
        found = column.match(line)
        if found:
            lines[k] = f":{found[1]}: {found[2]}"


def add_formulas(app, pagename, templatename, context, doctree):
    """The style sheet and the script that set formulas, on pages that have any."""
    if doctree is not None and any(doctree.findall(lambda n: isinstance(n, (nodes.math, nodes.math_block)))):
        app.add_css_file("katex/katex.min.css")
        app.add_js_file("katex/contrib/auto-render.js", loading_method="defer")
        app.add_js_file("formulas.js", loading_method="defer")


def copy_formulas(static):
    shutil.copytree(KATEX, static / "katex", dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns("*.mjs", "*.ttf", "*.woff", "katex.js", "katex.css"))
    shutil.copy(KATEX_LICENCE, static / "katex/copyright")


def complete_theme(static):
    """Debian's furo refers to a style sheet of the machine and to a module of JavaScript, which browsers do not load
    from files: both are put in. Its dark colours, which only the button brings, are also those of dark systems."""
    style, script = static / "styles/furo.css", static / "scripts/furo.js"
    text = style.read_text()
    if text.startswith(NORMALIZE_IMPORT):
        text = (JAVASCRIPT / "normalize.css/normalize.css").read_text() + text.removeprefix(NORMALIZE_IMPORT)
    dark = DARK_COLOURS.search(text)
    if dark and "prefers-color-scheme" not in text:
        text += f'@media screen and (prefers-color-scheme: dark) {{ body:not([data-theme="light"]) {{{dark[1]}}} }}\n'
    style.write_text(text)
    text = script.read_text()
    if text.startswith(GUMSHOE_IMPORT):
        gumshoe = static / "scripts/gumshoe-patched.js"
        script.write_text(gumshoe.read_text() + text.removeprefix(GUMSHOE_IMPORT))


def complete(app, exception):
    if exception is None and app.builder.format == "html":
        static = pathlib.Path(app.outdir) / "_static"
        copy_formulas(static)
        complete_theme(static)
        copy_pages(app)


def setup(app):
    app.add_lexer("lammps", TextLexer)
    app.add_object_type("key", "key", objname="deck key")
    app.add_object_type("word", "word", objname="word")
    app.connect("source-read", fill_names)
    app.connect("source-read", link_pages)
    app.connect("doctree-read", note_keys)
    app.connect("doctree-read", note_words)
    app.connect("doctree-read", note_other_words)
    app.connect("missing-reference", resolve_header)
    app.connect("doctree-resolved", name_pages)
    app.connect("autodoc-process-docstring", columns_to_fields)
    app.connect("html-page-context", add_formulas)
    app.connect("build-finished", complete)
