"""A second server on a rig that another one commands: its page says so, over the plan."""

import json
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from server.app.up import ServerChild
from server.settings import ServerSettings
from tests.e2e.product import Product


@pytest.mark.long  # tests/server/app/test_trouble.py shows the same of the servers
def test_the_page_of_a_second_server_names_the_first_and_its_e_stop_works(
    browser: Browser, product: Product, tmp_path: Path
) -> None:
    rig = json.loads(product.child("controller.realtime").cmdline()[-1])
    settings = ServerSettings(
        rig=rig["rig"], endpoint=rig["listen"], key_file=rig["key_file"], state=tmp_path, recordings=tmp_path, port=0
    )
    second = ServerChild(settings, tmp_path / "server.json")
    try:
        page = browser.new_context().new_page()
        page.goto(second.wait_ready().url)
        alert = page.get_by_test_id("refused")
        expect(alert).to_contain_text("takes no command from this server: refused: the server on")
        expect(alert).to_contain_text(f"(process {product.child('server.app').pid}) commands this rig since 20")
        page.get_by_test_id("e-stop").click()
        expect(page.get_by_test_id("state")).to_contain_text("E-STOP")
        page.context.close()
    finally:
        second.stop()
