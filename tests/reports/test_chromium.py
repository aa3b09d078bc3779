"""The page in a browser: nothing runs off the window, nothing is blank, it prints."""

import re
import shutil
import subprocess

import matplotlib.image
import pytest

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(BROWSER is None, reason="Chromium is not installed: the page is not looked at")

MEASURE = "<script>document.title = 'width ' + document.documentElement.scrollWidth;</script></body>"


def browse(tmp_path, *arguments):
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
    return subprocess.run([*command, *arguments], capture_output=True, timeout=60, check=True).stdout.decode()


def test_nothing_runs_off_a_narrow_window(written, tmp_path):
    page = tmp_path / "page.html"
    page.write_text(written.page.read_text(encoding="utf-8").replace("</body>", MEASURE), encoding="utf-8")
    found = browse(tmp_path, "--window-size=640,800", "--dump-dom", page.as_uri())
    assert int(re.search(r"<title>width (\d+)</title>", found).group(1)) <= 640


def test_the_page_is_drawn(written, tmp_path):
    picture = tmp_path / "page.png"
    browse(tmp_path, "--window-size=900,1400", f"--screenshot={picture}", written.page.as_uri())
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert pixels.shape[:2] == (1400, 900)
    assert 0.01 < (pixels.mean(axis=2) < 0.9).mean() < 0.3


def test_the_page_prints(written, tmp_path):
    paper = tmp_path / "page.pdf"
    browse(tmp_path, "--no-pdf-header-footer", f"--print-to-pdf={paper}", written.page.as_uri())
    data = paper.read_bytes()
    assert data.startswith(b"%PDF")
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b", data)) <= 25
