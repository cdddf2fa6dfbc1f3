"""Headless Chromium for tests of pages."""
import shutil


def spills(driver, width, height=700):
    """What reaches beyond the part of the page that it is in, at this width of the window; canvases without a name."""
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
    return driver.execute_async_script("""const done = arguments[0], parts = "header, footer, #tools, #legend, #key, #strip, aside";
      const look = () => {
        const found = document.documentElement.scrollWidth > innerWidth ? [`the page, ${document.documentElement.scrollWidth}`] : [];
        for (const part of document.querySelectorAll(parts)) {
          const box = part.getBoundingClientRect();
          for (const one of part.querySelectorAll(":scope *:not(svg *)")) {
            const at = one.getBoundingClientRect();
            if (at.width > 0 && at.height > 0 && (at.right > box.right + 0.6 || at.left < box.left - 0.6))
              found.push(`${one.tagName}#${one.id} ${at.left}..${at.right} in ${part.tagName}#${part.id} ${box.left}..${box.right}`);
          }
        }
        for (const canvas of document.querySelectorAll("canvas"))
          if (canvas.getAttribute("role") !== "img" || !canvas.getAttribute("aria-label")) found.push(`a canvas without a name`);
        return found;
      };
      /* plots follow the width some frames later */
      let left = 20;
      const again = () => { const found = look(); if (found.length === 0 || left-- === 0) done(found); else requestAnimationFrame(again); };
      requestAnimationFrame(again);""")


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
