"""The web page in a headless Chromium, as a person uses it: what the tests of the page share."""

import contextlib

from playwright.sync_api import Page, sync_playwright

CHROMIUM = "/usr/bin/chromium"
# Root in a container has no user namespaces to sandbox with; the pages are our own.
ARGUMENTS = ["--no-sandbox", "--disable-dev-shm-usage"]


@contextlib.contextmanager
def chromium():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@contextlib.contextmanager
def opened(browser, url, **options):
    """The page at `url`, with pictures in its grid; nothing may be said on the browser's console meanwhile."""
    context = browser.new_context(**{"viewport": {"width": 1440, "height": 900}, **options})
    page = context.new_page()
    page.set_default_timeout(20_000)
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    try:
        page.goto(url)
        page.wait_for_selector("#stage[aria-labelledby] #picture[data-frames]")
        yield page
    finally:
        context.close()
    assert said == [], said


def until(page: Page, expression: str) -> None:
    """Waits for a JavaScript expression to hold. (Playwright's own way evaluates text in the page, which its Content-
    Security-Policy forbids.)"""
    for _ in range(400):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    raise AssertionError(f"never came: {expression}")


@contextlib.contextmanager
def streams_opened(page: Page, name: str):
    """Of this camera, which the block brings to the grid and the stage: when it is over, the page has both streams, and opens none again.

    A stream that it asks for while the camera is deleted is answered by 404, which Chromium writes on its console. In lockstep it opens a stream again when
    the camera is another one than when it was opened, at a look before which no picture has come (live.js): two looks later at the latest.
    """
    asked, looks = [], []

    def note(request):
        if "/live?" in request.url:
            asked.append(request)
            looks.clear()
        elif '"camera.list"' in (request.post_data or ""):
            looks.append(request)  # those before it have been taken in

    page.on("request", note)
    yield
    until(page, f"document.getElementById('stage-name').textContent === '{name}'")
    until(page, f"document.querySelector('.tile[data-camera={name}] canvas[data-frames]')")
    looks.clear()
    for _ in range(400):
        if len(looks) >= 3:
            break
        page.wait_for_timeout(50)
    page.remove_listener("request", note)
    answers = [request.response() for request in asked]
    assert len(looks) >= 3 and answers and all(answer is None or answer.status == 200 for answer in answers), (len(looks), answers)  # None: of one that was asked for anew


@contextlib.contextmanager
def held(page: Page, url: str, word: str = ""):
    """Requests to `url` with `word` in their body wait, in the list that this gives, until let_go(). Others to it go on while the page is asked something:
    wait with until(), not in Python alone."""
    waiting = []
    page.route(url, lambda route: waiting.append(route) if word in (route.request.post_data or "") else route.fallback())
    yield waiting
    page.unroute_all(behavior="ignoreErrors")


def let_go(page: Page, waiting: list) -> None:
    """Lets the first request go on that waits, or the first that will; it has been answered when this returns."""
    for _ in range(400):
        if waiting:
            break
        page.wait_for_timeout(50)
    route = waiting.pop(0)
    with page.expect_response(lambda response: response.request == route.request) as answer:
        route.continue_()
    answer.value.finished()


def pixels(page: Page, canvas="#picture") -> list[int]:
    """Every 97th pixel of a canvas, as numbers."""
    return page.evaluate(
        """selector => { const canvas = document.querySelector(selector);
           const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {willReadFrequently: true});
           copy.drawImage(canvas, 0, 0);
           const all = copy.getImageData(0, 0, canvas.width, canvas.height).data;
           return Array.from(all).filter((_, index) => index % 388 < 3); }""", canvas)


def difference(before: list[int], after: list[int]) -> float:
    """Mean difference of two pictures, in codes."""
    assert len(before) == len(after)
    return sum(abs(a - b) for a, b in zip(before, after)) / len(before)


def wait_for_picture(page: Page, than: list[int], least: float) -> list[int]:
    """The picture, once it differs from `than` by at least so much."""
    for _ in range(200):
        now = pixels(page)
        if len(now) == len(than) and difference(than, now) >= least:
            return now
        page.wait_for_timeout(50)
    raise AssertionError(f"the picture did not change by {least}, but by {difference(than, now)}")


def middle(page: Page, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page: Page, selector: str, dx: float, dy: float) -> None:
    x, y = middle(page, selector)
    page.mouse.move(x, y)
    page.mouse.down()
    for part in range(1, 5):
        page.mouse.move(x + dx * part / 4, y + dy * part / 4)
    page.mouse.up()


def metres_per_pixel(page: Page) -> float:
    """Of the top view, from the numbers on its grid."""
    ticks = page.eval_on_selector_all("#map .tick", "all => all.map(one => [Number(one.getAttribute('x')), Number(one.getAttribute('y')), Number(one.textContent)])")
    bottom = max(y for _, y, _ in ticks)
    row = sorted((x, value) for x, y, value in ticks if y == bottom)
    return (row[-1][1] - row[0][1]) / (row[-1][0] - row[0][0])

