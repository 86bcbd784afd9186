"""The main tests of the live machine's page once more, in Firefox. That of a model has one in `test_model_page.py`."""

import pytest

from browser import firefox
from machine_page import PAGE, page  # noqa: F401
from test_machine_page import test_the_page_opens_from_a_folder_and_moves  # noqa: F401 (the first: the others pause it)
from test_machine_page import (  # noqa: F401
    test_a_bad_address_offers_the_usual_settings,
    test_a_link_is_copied_where_there_is_no_clipboard,
    test_a_red_bar_ends_with_its_cause_and_can_be_closed,
    test_an_address_holds_what_was_changed_while_it_ran,
    test_any_order_of_clicks_ends_in_a_running_page,
    test_ghosts_that_are_ticked_at_once,
)
from test_machine_page_leading import (  # noqa: F401
    test_a_gamepad_that_is_first_seen_while_it_is_moved_rests_at_zero,
    test_a_waypoint_that_cannot_be_reached_is_taken_back,
    test_keys_are_named_as_they_are_printed,
    test_letters_lead_while_a_list_has_the_focus,
    test_levers_on_the_screen_and_keys_move_the_joints,
    test_the_emergency_stop_and_the_reset,
    test_the_tip_is_pushed_by_dragging,
    test_two_sticks_lead_and_their_axes_can_be_changed,
)
from test_machine_page_picture import test_the_machine_is_drawn_where_the_fmu_has_it  # noqa: F401


@pytest.fixture(scope="module")
def opened():
    """The browser, with the page as it opens."""
    driver = firefox()
    driver.get(PAGE.as_uri())
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def clicks():
    return 300
