"""Makes addin_sdfusion/commands/help.html, and its picture, from the dialogs of the add-in.

python docs/make_addin_page.py            the page
python docs/make_addin_page.py --png      and, with Chromium, docs/images/addin_dialogs.png and the
                                          pictures that buttons of the add-in show

The page is the help of the add-in's commands, too.
"""

from __future__ import annotations

import base64
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from addin_examples import CHECK as CHECK_EXAMPLE  # noqa: E402
from addin_examples import DEFINE as DEFINE_EXAMPLE  # noqa: E402
from addin_examples import EXPORT as EXPORT_EXAMPLE  # noqa: E402
from addin_examples import Example  # noqa: E402

from addin_sdfusion.commands.check.dialog import DIALOG as CHECK  # noqa: E402
from addin_sdfusion.commands.define_muscles.dialog import DIALOG as DEFINE  # noqa: E402
from addin_sdfusion.commands.dialogs import Dialog, Input  # noqa: E402
from addin_sdfusion.commands.export.dialog import DIALOG as EXPORT  # noqa: E402

PAGE = ROOT / "addin_sdfusion" / "commands" / "help.html"
PICTURE = ROOT / "docs" / "images" / "addin_dialogs.png"
DIALOGS = ((DEFINE, DEFINE_EXAMPLE), (CHECK, CHECK_EXAMPLE), (EXPORT, EXPORT_EXAMPLE))

STYLE = """
body { font: 13px/1.35 "Segoe UI", "Helvetica Neue", Arial, sans-serif; margin: 24px;
  background: #dfe3e8; color: #22262b; }
h1 { font-size: 20px; margin: 0 0 4px; } h2 { font-size: 16px; margin: 22px 0 2px; }
h2 img { vertical-align: -7px; margin-right: 8px; }
p { margin: 0 0 10px; max-width: 48em; }
.row { display: flex; flex-wrap: wrap; gap: 18px; align-items: flex-start; }
section { max-width: 100%; } main { display: flex; flex-wrap: wrap; gap: 0 34px; }
.window { background: #f7f8f9; border: 1px solid #8c949d; border-radius: 4px;
  box-shadow: 0 3px 9px #0004; }
.title { background: #3b444e; color: #fff; padding: 5px 10px; border-radius: 3px 3px 0 0; }
.tabs { display: flex; background: #e3e6ea; border-bottom: 1px solid #b9c0c7; }
.tabs span { padding: 5px 9px; color: #59616a; white-space: nowrap; }
.tabs .open { background: #f7f8f9; color: #06528f; border-bottom: 2px solid #0a77cc; }
.body { padding: 8px 10px; }
.line { display: flex; gap: 8px; margin: 5px 0; align-items: flex-start; }
.line > .label { flex: 0 0 34%; padding-top: 3px; }
.line > .field { flex: 1 1 auto; min-width: 0; }
.box { border: 1px solid #b4bac1; background: #fff; min-height: 19px; padding: 2px 6px;
  border-radius: 2px; overflow-wrap: anywhere; }
.box.down::after { content: "\\25be"; float: right; color: #59616a; }
.box.pick { background: #e5f1fb; border-color: #0a77cc; }
.box.message { background: #eef0f2; white-space: pre-wrap; }
.tick { display: inline-block; width: 14px; height: 14px; line-height: 14px; text-align: center;
  border: 1px solid #7d858e; background: #fff; border-radius: 2px; }
.button { display: inline-block; border: 1px solid #9aa2aa; background: #eceef1; padding: 3px 10px;
  border-radius: 3px; margin: 2px 4px 2px 0; }
.group { font-weight: 600; margin: 10px 0 2px; border-bottom: 1px solid #cdd2d7; }
table { border-collapse: collapse; width: 100%; table-layout: fixed; background: #fff; }
td, th { border: 1px solid #cdd2d7; padding: 2px 5px; text-align: left; font-weight: 400;
  overflow-wrap: anywhere; vertical-align: top; }
th { background: #eef0f2; color: #59616a; } tr.selected td { background: #cfe6fa; }
td.down::after { content: "\\25be"; float: right; color: #59616a; }
.end { text-align: right; padding: 6px 10px 10px; }
.end .ok { background: #0a77cc; color: #fff; border-color: #0a77cc; }
"""


def page() -> str:
    """Return the page, which needs no other file."""
    parts = [_part(dialog, example) for dialog, example in DIALOGS]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>CARDSFlow in Fusion</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        "<h1>CARDSFlow in Fusion: the three dialogs</h1>\n"
        "<p>Made from the definitions that the add-in makes its dialogs from, with example "
        "content. Fusion draws the inputs in its own style. Rest the pointer on an input to read "
        "what it is for.</p>\n"
        f"<main>\n{''.join(parts)}</main>\n</body>\n</html>\n"
    )


def _part(dialog: Dialog, example: Example) -> str:
    icon = ROOT / "addin_sdfusion/commands" / dialog.folder / "resources/32x32.png"
    tabs = [item for item in dialog.inputs if item.kind == "tab"]
    windows = [window(dialog, example, tab) for tab in tabs or [None]]
    return (
        f"<section><h2>{_image(icon, 24)}{escape(dialog.name)}</h2>\n"
        f"<p>{escape(dialog.tooltip)} {escape(dialog.description)}</p>\n"
        f'<div class="row">\n{"".join(windows)}</div></section>\n'
    )


def window(dialog: Dialog, example: Example, tab: Input | None) -> str:
    """Return the HTML of a dialog with an open tab."""
    tabs = "".join(
        f'<span class="{"open" if item is tab else ""}">{escape(item.label)}</span>'
        for item in dialog.inputs
        if item.kind == "tab"
    )
    shown = [
        i for item in dialog.inputs for i in ([item] if item.kind != "tab" else _of(item, tab))
    ]
    body = "".join(_line(item, example) for item in shown)
    ok = f'<span class="button ok">{escape(dialog.ok)}</span>' if dialog.ok else ""
    return (
        f'<div class="window" style="width: {dialog.size[0]}px">'
        f'<div class="title">{escape(dialog.name.upper())}</div>'
        f'{f"<div class=tabs>{tabs}</div>" if tabs else ""}<div class="body">\n{body}</div>'
        f'<div class="end">{ok}<span class="button">{escape(dialog.cancel)}</span></div></div>\n'
    )


def _of(item: Input, tab: Input | None) -> tuple[Input, ...]:
    return item.children if item is tab else ()


def _line(item: Input, example: Example) -> str:
    """Return the HTML of an input with its value."""
    if item.id in example.hidden:
        return ""
    about = f' title="{escape(item.tooltip)}"' if item.tooltip else ""
    label = escape(item.label)
    if item.kind == "group":
        inner = "".join(_line(child, example) for child in item.children)
        return f'<div class="group">&#9662; {label}</div>\n{inner}'
    if item.kind == "table":
        return f"<div{about}>{_table(item, example)}</div>\n"
    if item.kind == "button":
        return f'<div class="line"{about}><span class="button">{label}</span></div>\n'
    field = _field(item, example)
    return (
        f'<div class="line"{about}><div class="label">{label}</div>'
        f'<div class="field">{field}</div></div>\n'
    )


def _field(item: Input, example: Example) -> str:
    value = example.values.get(item.id, item.value)
    if item.kind == "check":
        return f'<span class="tick">{"&#10003;" if value else ""}</span>'
    if item.kind == "selection":
        return f'<div class="box pick">{escape(item.prompt)}</div>'
    look = {"dropdown": "box down", "choices": "box down", "text": "box message"}.get(
        item.kind, "box"
    )
    text = f"{value:g}" if isinstance(value, float) else str(value)
    if item.kind == "dropdown" and not text and item.options:
        text = item.options[0]
    least = f' style="min-height: {18 * item.rows}px"' if item.kind == "text" else ""
    return f'<div class="{look}"{least}>{escape(text)}</div>'


def _table(item: Input, example: Example) -> str:
    total = sum(item.widths)
    heads = "".join(
        f'<th style="width: {100 * width / total:.0f}%">{escape(column)}</th>'
        for column, width in zip(item.columns, item.widths, strict=True)
    )
    icons = example.icons.get(item.id, {})
    drops = example.choices.get(item.id, (False,) * len(item.columns))
    rows = []
    for i, row in enumerate(example.cells.get(item.id, ())):
        cells = "".join(
            f"<td{' class=down' if drop else ''}>{_cell(cell, icons)}</td>"
            for cell, drop in zip(row, drops, strict=True)
        )
        chosen = example.selected.get(item.id) == i
        rows.append(f"<tr{' class=selected' if chosen else ''}>{cells}</tr>")
    buttons = "".join(
        f'<span class="button" title="{escape(child.tooltip)}">{escape(child.label)}</span>'
        for child in item.children
    )
    return f"<table><tr>{heads}</tr>{''.join(rows)}</table><div>{buttons}</div>"


def _cell(text: str, icons: Mapping[str, str]) -> str:
    """Return the HTML of a text, or of the icon that replaces it."""
    if text not in icons:
        return escape(text)
    file = ROOT / "addin_sdfusion/commands" / icons[text] / "32x32.png"
    return _image(file, 16, text)


def _image(file: Path, width: int, text: str = "") -> str:
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    return f'<img alt="{escape(text)}" width="{width}" src="data:image/png;base64,{data}">'


def picture() -> None:
    """Draw the page with Chromium, in few colours."""
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.write_bytes(shot(page(), (2400, 3000), 64))
    for dialog, example in DIALOGS:
        tab = next((item for item in dialog.inputs if item.kind == "tab"), None)
        body = f"<style>body {{ margin: 6px; zoom: 0.75 }}</style>{window(dialog, example, tab)}"
        width = round(0.75 * dialog.size[0]) + 24
        clip = ROOT / "addin_sdfusion/commands" / dialog.folder / "resources/toolclip.png"
        clip.write_bytes(shot(f"<!DOCTYPE html><style>{STYLE}</style>{body}", (width, 900), 16, 6))


def shot(text: str, size: tuple[int, int], colors: int, margin: int = 24) -> bytes:
    """Return a PNG of a page with a number of colours, without empty right and lower margins."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("there is no Chromium on this machine")
    with tempfile.TemporaryDirectory() as folder:
        shot, html = Path(folder) / "page.png", Path(folder) / "page.html"
        html.write_text(text, encoding="utf-8")
        command = [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
        command += [f"--screenshot={shot}", f"--window-size={size[0]},{size[1]}", html.as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        return _small(shot, colors, margin)


def _small(shot: Path, colors: int, margin: int) -> bytes:
    import io

    from PIL import Image, ImageChops

    image = Image.open(shot).convert("RGB")
    ground = Image.new("RGB", image.size, image.getpixel((0, 0)))
    box = ImageChops.difference(image, ground).getbbox() or (0, 0, *image.size)
    right, below = box[2] + margin, box[3] + margin
    image = image.crop((0, 0, min(right, image.width), min(below, image.height)))
    out = io.BytesIO()
    image.quantize(colors, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


def main() -> None:
    """Write the page, and its picture if asked."""
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    if "--png" in sys.argv[1:]:
        picture()


if __name__ == "__main__":
    main()
