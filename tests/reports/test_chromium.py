"""The page in a browser: nothing runs off the window, nothing is blank, it prints."""

import dataclasses
import importlib.resources
import re
import shutil
import subprocess

import matplotlib.image
import pytest

from data_schema.outcomes import Outcome
from reports.page.writing import render_page
from reports.tables.registry import TABLES
from tests.helpers.pages import DRAWN, quick_page
from tests.helpers.wording import says

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(BROWSER is None, reason="Chromium is not installed: the page is not looked at")

CUT = """<script>document.title = 'cut:' + [...document.querySelectorAll('.table')]
.filter(box => box.scrollWidth > box.clientWidth + 1).map(box => box.querySelector('caption').textContent).join(' | ');
</script></body>"""
OUTSIDE = """<script>document.title = 'outside:' + [...document.querySelectorAll('table, svg, p, li, figcaption')]
.filter(part => part.getBoundingClientRect().right > innerWidth + 1).map(part => part.textContent.slice(0, 60))
.join(' | ');
</script></body>"""
DRAWINGS = dict.fromkeys(
    DRAWN, b'<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9"></svg>'
)


def browse(tmp_path, *arguments):
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
    return subprocess.run([*command, *arguments], capture_output=True, timeout=60, check=True).stdout.decode()


def without_policy(page):
    """The page as one that runs other scripts than its own."""
    return re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", page)


def title_of(tmp_path, page, width, script):
    """What a script put into the title of a page in a window so wide."""
    path = tmp_path / "page.html"
    path.write_text(without_policy(page).replace("</body>", script), encoding="utf-8")
    size = f"--window-size={width},1000"
    found = browse(tmp_path, size, "--virtual-time-budget=30000", "--dump-dom", path.as_uri())
    return re.search(r"<title>(.*?)</title>", found).group(1)


def test_the_page_is_drawn(written, tmp_path):
    picture = tmp_path / "page.png"
    browse(tmp_path, "--window-size=900,1400", f"--screenshot={picture}", written.as_uri())
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert pixels.shape[:2] == (1400, 900)
    assert 0.01 < (pixels.mean(axis=2) < 0.9).mean() < 0.3


HOSTILE = """<script>document.title = "hostile"</script><img src="x" onerror="document.title = 'hostile'">
<img src="https://example.invalid/x.png" onerror="document.title = 'hostile'"></body>"""


def test_the_page_runs_its_own_script_and_no_other(written, tmp_path):
    page = tmp_path / "page.html"
    page.write_text(written.read_text(encoding="utf-8").replace("</body>", HOSTILE), encoding="utf-8")
    shown = browse(tmp_path, "--virtual-time-budget=3000", "--dump-dom", page.as_uri())
    assert "<title>hostile" not in shown
    assert shown.count("<button") > page.read_text(encoding="utf-8").count("<button")
    page.write_text(without_policy(page.read_text(encoding="utf-8")), encoding="utf-8")
    assert "<title>hostile" in browse(tmp_path, "--virtual-time-budget=3000", "--dump-dom", page.as_uri())


@pytest.mark.parametrize(("paper", "width_pt"), [("A4", 595), ("Letter", 612)])
@pytest.mark.soak
def test_the_page_prints_on_the_paper_that_is_there(written, tmp_path, paper, width_pt):
    page, printed = tmp_path / "page.html", tmp_path / "page.pdf"
    text = written.read_text(encoding="utf-8")
    assert not re.search(r"@page[^}]*size", text)
    page.write_text(text.replace("@page {", f"@page {{ size: {paper};"), encoding="utf-8")
    browse(tmp_path, "--no-pdf-header-footer", f"--print-to-pdf={printed}", page.as_uri())
    data = printed.read_bytes()
    assert data.startswith(b"%PDF")
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b", data)) <= 30
    boxes = {round(float(width)) for width in re.findall(rb"/MediaBox \[0 0 ([\d.]+)", data)}
    assert boxes == {width_pt}


@pytest.mark.soak
def test_nothing_is_cut_on_paper(written, tmp_path):
    """The page as it is printed, on a window as wide as A4 paper between its margins; Letter is wider."""
    page = written.read_text(encoding="utf-8").replace("@media print", "@media all")
    assert title_of(tmp_path, page, int(178 / 25.4 * 96), OUTSIDE) == "outside:"


@pytest.mark.soak
def test_long_names_are_wrapped_and_nothing_of_a_table_is_cut(content, tmp_path):
    name = "pack_with_a_very_long_name_" * 4
    comparisons = tuple(dataclasses.replace(c, family=f"{name} {c.family}") for c in content.comparisons)
    days = tuple(dataclasses.replace(day, packs=(name,)) for day in content.days)
    changed = dataclasses.replace(content, comparisons=comparisons, days=days)
    tables = {kind.name: kind.make(changed) for kind in TABLES.values()}
    assert title_of(tmp_path, render_page(changed, DRAWINGS, tables), 1000, CUT) == "cut:"


ON_A_TELEPHONE = """addEventListener("load", () => {
const box = document.querySelector("#answer .table");
const hidden = Math.max(0, box.scrollWidth - box.clientWidth), range = document.createRange();
for (const fold of document.querySelectorAll(".fold details")) fold.open = true;
const lines = (text, word) => {
range.setStart(text, word.index);
range.setEnd(text, word.index + word[0].length);
return range.getClientRects().length; };
const torn = [...document.querySelectorAll("td:first-child")].map(cell => cell.firstChild)
.flatMap(text => text?.data ? [...text.data.matchAll(/[^ ]*\u00a0[^ ]*/g)].filter(word => lines(text, word) > 1) : []);
tell(`${innerWidth} px: ${hidden} hidden, ${torn.length} torn`);
});"""
IN_A_NARROW_WINDOW = """const width = document.documentElement.scrollWidth;
addEventListener("load", () => {
document.querySelector("#figure-joules_by_level a").dispatchEvent(new MouseEvent("click", {bubbles: true}));
document.querySelector("#figure-joules_by_level button").click();
const copy = document.querySelector("dialog svg");
const before = copy.viewBox.baseVal.width;
document.querySelector("dialog button").click();
const open = document.querySelector("#measured details").open;
tell(`width ${width} open ${open} zoomed ${copy.viewBox.baseVal.width < before}`);
});"""
IN_ROW = """addEventListener("load", () => {
const fold = document.querySelector("tr[id] .jumps"), drawn = fold.querySelector("svg");
const told = () => fold.querySelector("span").textContent;
reveal(fold.closest("tr").id);
drawn.dispatchEvent(new PointerEvent("pointermove", {clientX: drawn.getBoundingClientRect().right}));
const over = told();
drawn.dispatchEvent(new PointerEvent("pointerleave"));
tell(`open ${fold.open}: ${over}; ${told()}`);
});"""
GATHER = """<script>addEventListener("message", said => {
  document.body.append(Object.assign(document.createElement("p"), {textContent: said.data})); });</script>"""


@pytest.fixture(scope="module")
def told(content, written, tmp_path_factory):
    """What pages told of themselves in frames of their widths, by name: one browser for all, for to start it takes
    longest, and no window of one is narrower than 500 px.
    """
    folder, whole = tmp_path_factory.mktemp("frames"), written.read_text(encoding="utf-8")
    pages = {
        "telephone": (360, whole, ON_A_TELEPHONE),
        "narrow": (640, whole, IN_A_NARROW_WINDOW),
        "row": (900, quick_page(with_jumps(content)), IN_ROW),
    }
    frames = []
    for name, (width, text, script) in pages.items():
        tell = f'const tell = said => parent.postMessage("{name}: " + said, "*");'
        page = without_policy(text).replace("</body>", f"<script>{tell}{script}</script></body>")
        (folder / f"{name}.html").write_text(page, encoding="utf-8")
        frames.append(f'<iframe src="{name}.html" style="width: {width}px; height: 800px; border: 0"></iframe>')
    frame = folder / "frames.html"
    frame.write_text(f"<!DOCTYPE html><html><body>{GATHER}{''.join(frames)}</body></html>", encoding="utf-8")
    found = browse(folder, "--window-size=1000,800", "--virtual-time-budget=3000", "--dump-dom", frame.as_uri())
    return dict(re.findall(r"<p>(\w+): (.*?)</p>", found))


def with_jumps(content):
    heights_m = {2: 0.31, 4: 0.33}
    of_first = {run for run, _value in content.conditions[0].summaries[Outcome.APEX].runs}
    jumped = {run: dataclasses.replace(content.runs[run], heights_m=heights_m) for run in of_first}
    return dataclasses.replace(content, runs={**content.runs, **jumped})


def test_on_a_telephone_the_table_of_page_one_does_not_scroll_and_no_unit_is_torn_from_its_number(told):
    assert told["telephone"] == "360 px: 0 hidden, 0 torn"


def test_in_a_narrow_window_nothing_runs_off_a_point_opens_the_rows_of_runs_and_a_figure_zooms(told):
    width, zoomed = re.fullmatch(r"width (\d+) open true zoomed (\w+)", told["narrow"]).groups()
    assert int(width) <= 640
    assert zoomed == "true"


def test_a_link_to_a_run_opens_its_jumps_which_are_told_one_by_one(told):
    says(told["row"], "open true: jump 4: 330.0 mm; 2, 310 to 330 mm")


AXE = """<script>{axe}</script><script>
axe.run({{resultTypes: ["violations"]}}).then(found => {{ document.title = "axe:" + found.violations
  .filter(rule => ["serious", "critical"].includes(rule.impact))
  .map(rule => `${{rule.id}} (${{rule.nodes.length}}): ${{rule.nodes[0].html.slice(0, 90)}}`).join(" | "); }});
</script></body>"""


def beginning(table):
    """The table with its first two rows."""
    return dataclasses.replace(table, rows=table.rows[:2])


@pytest.mark.parametrize(
    ("whole", "width"), [(False, 1280), *(pytest.param(True, width, marks=pytest.mark.soak) for width in (1280, 400))]
)
def test_axe_finds_nothing_serious(content, request, tmp_path, whole, width):
    """The accessibility rules of axe-core, on the page with all folds open; figures and long tables take it seconds."""
    axe = (importlib.resources.files("axe_core_python") / "axe.min.js").read_text(encoding="utf-8")
    text = (
        request.getfixturevalue("written").read_text(encoding="utf-8")
        if whole
        else render_page(content, DRAWINGS, {kind.name: beginning(kind.make(content)) for kind in TABLES.values()})
    )
    assert title_of(tmp_path, text.replace("<details", "<details open"), width, AXE.format(axe=axe)) == "axe:"
