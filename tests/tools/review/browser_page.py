"""The page of `orient review` in Debian's Chromium, as tests read and operate it."""

import shutil
import time

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]



class Page:
    """What a person sees and does; every wait has a time limit."""

    def __init__(self, browser, keys, actions):
        self.browser, self.keys, self.actions = browser, keys, actions

    def open(self, address):
        self.browser.get(address)
        self.until(lambda: self.text("name") != "No photo", "a photo is shown")

    def until(self, true, what, seconds=60):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, f"not seen: {what}; message: {self.text('message')}"
            time.sleep(0.1)

    def at(self, name):
        return self.browser.find_element("id", name)

    def text(self, name):
        return self.browser.execute_script(
            f"const e = document.getElementById('{name}'); return e.hidden ? '' : e.textContent")

    def press(self, *keys):
        self.actions(self.browser).send_keys(*keys).perform()

    def type(self, name, text):
        self.at(name).clear()
        self.at(name).send_keys(text)

    def click_stage(self, name, dx=0, dy=0):
        self.actions(self.browser).move_to_element_with_offset(self.at(name), dx, dy).click().perform()

    def said(self, text):
        self.until(lambda: self.text("message") == text, text)

    def script(self, text):
        return self.browser.execute_script("return " + text)

    def errors(self):
        return [entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]

    def foreign_requests(self):
        return self.script("performance.getEntries().map((e) => e.name).filter((n) => "
                           "n.includes('://') && !n.startsWith(location.origin + '/'))")

    def measure_by_keys(self, mark, pixel):
        """Moves the pixel under the cross and measures it there."""
        while self.at("mark").get_attribute("value") != mark or not self.script("review.mode"):
            self.press("m")
        self.browser.execute_script(
            "photoView.map.setView(photoView.placeOf(arguments[0]), 0, {animate: false})", list(pixel))
        self.press(self.keys.ARROW_RIGHT, self.keys.ARROW_LEFT, self.keys.ENTER)
        self.said(f"Saved: mark {mark} of photo {self.text('name')}")

    def picture(self, folder, name):
        if folder:
            self.browser.save_screenshot(str(folder / f"{name}.png"))


def start_browser():
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    options = webdriver.ChromeOptions()
    for flag in [*FLAGS, "--window-size=1400,900"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
