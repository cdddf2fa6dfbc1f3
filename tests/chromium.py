"""Headless Chromium for tests of pages."""
import importlib.util
import shutil


def missing(*modules):
    """What is not installed of Chromium, its driver, selenium and these modules."""
    names = [name for name in ("selenium", *modules) if importlib.util.find_spec(name) is None]
    return names + [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]


def browser():
    """Chromium that reaches no network, and tells what pages ask for."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for word in ("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                 "--proxy-server=127.0.0.1:9", "--disable-dev-shm-usage"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
