"""The report in a browser: nothing missing, no errors, tables that sort."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.chrome.service import Service

Finished = tuple[Path, subprocess.CompletedProcess]


@pytest.fixture(name="page", scope="module")
def opened(finished: Finished, tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                 "--window-size=1300,1000", f"--user-data-dir={tmp_path_factory.mktemp('browser')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    try:
        browser.get((finished[0] / "report.html").as_uri())
        yield browser
    finally:
        browser.quit()


def test_nothing_is_loaded_from_elsewhere_and_the_console_is_empty(
        finished: Finished, page: webdriver.Chrome) -> None:
    html = (finished[0] / "report.html").read_text(encoding="utf-8")
    assert set(re.findall(r'(?:src|href)="([a-z]+):', html)) == {"data"}
    assert not re.search(r'(?:src|href)="(?!data:)', html)
    assert page.get_log("browser") == []


def test_pictures_load(page: webdriver.Chrome) -> None:
    widths = page.execute_script("return [...document.images].map(image => image.naturalWidth)")
    assert len(widths) == 2 + 3  # two figures; the initial mesh and two variants
    assert min(widths) > 100


def column(page: webdriver.Chrome, table: str, k: int) -> list[str]:
    return page.execute_script(
        f"return [...document.querySelector('#{table}').tBodies[0].rows]"
        f".map(row => row.cells[{k}].dataset.sort)")


def test_tables_sort_both_ways_with_missing_values_last(page: webdriver.Chrome) -> None:
    heading = page.find_elements(By.CSS_SELECTOR, "#scene-relief thead th")[1]
    for sign, state in ((1, "ascending"), (-1, "descending")):
        heading.click()
        assert heading.get_attribute("aria-sort") == state
        values = column(page, "scene-relief", 1)
        assert values[-1] == ""  # the variant that failed
        numbers = [sign * float(value) for value in values[:-1]]
        assert len(numbers) == 3 and numbers == sorted(numbers)


def test_best_values_are_marked_and_failures_said(page: webdriver.Chrome) -> None:
    best = page.find_elements(By.CSS_SELECTOR, "#scene-relief td.best")
    assert len(best) >= 4
    text = page.find_element(By.TAG_NAME, "body").text
    assert "failed (1 of 1)" in text
    assert "runs/relief-seed1/refused" in text
    assert "smooth.weight" in page.find_element(By.ID, "options").text


def test_shares_that_matched_stand_beside_errors_and_ranks(page: webdriver.Chrome) -> None:
    headings = page.execute_script(
        "return [...document.querySelectorAll('#scene-relief thead th')].map(one => one.textContent)")
    assert headings[1:8] == ["acc. mean", "acc. median", "compl. mean", "compl. median", "within",
                             "acc. matched %", "compl. matched %"]
    assert "matched %" in page.find_element(By.ID, "overview").text
    first = page.execute_script(
        "return [...document.querySelector('#ranks').tBodies[0].rows[0].cells].map(one => one.textContent)")
    assert first[0].startswith("relief, acc. mean (within ")
    assert first[1].endswith(" %") and first[3] == "–"
