"""rerun's page is changed where we mean it, and its files are kept by browsers."""

from server.recorder.rerun_routes import CHANGES, VERSION, rerun_page
from tests.server.live_server import TestServer, wait_for


def test_the_page_in_the_wheel_has_all_that_we_change_once(server: TestServer) -> None:
    page = server.page().sign_in()
    wait_for(lambda: page.get("/rerun/").status_code == 200, "the viewer")
    folder = server.services.review.viewer
    assert folder
    shipped = (folder / "index.html").read_bytes()
    assert [shipped.count(old) for old, _ in CHANGES] == [1] * len(CHANGES)
    served = page.get("/rerun/").content
    assert served == rerun_page(shipped)
    assert f'fetch("./re_viewer_bg.wasm?v={VERSION}")'.encode() in served
    assert f'src="re_viewer.js?v={VERSION}"'.encode() in served
    assert b"googleapis" in shipped and b"googleapis" not in served, "nothing is loaded from elsewhere"
    assert served.index(b"nothing is asked of other servers") < served.index(b'src="re_viewer.js')
    for signs in (b'postMessage("READY"', b"window._handle = handle", b"add_receiver"):
        assert signs in served, "what our page and the viewer's say to one another"


def test_files_of_a_version_are_kept_for_good_and_others_asked_for_again(server: TestServer) -> None:
    page = server.page().sign_in()
    wait_for(lambda: page.get("/rerun/").status_code == 200, "the viewer")
    kept = page.get(f"/rerun/re_viewer.js?v={VERSION}")
    assert "immutable" in kept.headers["cache-control"]
    for address in ("/rerun/re_viewer.js", "/rerun/re_viewer.js?v=0.1"):
        answer = page.get(address)
        assert answer.headers["cache-control"] == "no-cache"
        assert page.get(address, headers={"if-none-match": answer.headers["etag"]}).status_code == 304


def test_while_it_is_unpacked_the_page_asks_again_by_itself(server: TestServer) -> None:
    page, review = server.page().sign_in(), server.services.review
    wait_for(lambda: review.viewer, "the viewer")
    folder, review.viewer = review.viewer, None
    answer = page.get("/rerun/")
    review.viewer = folder
    assert (answer.status_code, answer.headers["refresh"]) == (503, "3")
