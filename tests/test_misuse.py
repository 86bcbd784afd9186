"""Misuse: each kind is refused with a message that names what was wrong, the value and what is allowed, and changes nothing."""

import re
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer
from decimal import Decimal
from pathlib import Path

import pytest

from fmu import DISCARD, ERROR, OK, Refused

REAL_INPUT = {"Emla": "x", "Hdrm": "f[2]", "Controller": "zeta[2]"}
REAL_OUTPUT = {"Emla": "F", "Hdrm": "x[1]", "Controller": "v_q[1]"}
FIXED = {"Emla": "R_s", "Hdrm": "inertia_scale", "Controller": "settle_time"}
LIMITED = {"Emla": ("R_s", -1.0), "Hdrm": ("payload.mass", -2.0), "Controller": ("gamma", 0.0)}


@pytest.fixture
def running(fmu):
    """Each FMU in Step Complete after one step."""
    instance = fmu.running()
    instance.step(0.0, 1e-3)
    yield instance
    instance.free()


def refused(instance, call, *words, status=ERROR):
    """`call` is refused with `status`, the message has all `words`, category and format are right, nothing is changed."""
    instance.call("fmi2SetDebugLogging", 1, 0, None)  # messages of fmi2Discard obey it
    before, count = instance.serialize(), len(instance.messages)
    try:
        result = call()
    except Refused as refusal:
        result = refusal.status
    assert result == status
    name, level, category, form, text = instance.messages[-1]
    assert len(instance.messages) == count + 1
    assert (name, level) == (instance.name, status)
    assert not re.search("[%#]", re.sub("%%|##", "", form)), f"the message is no text without arguments: {form}"
    assert category == {ERROR: "logStatusError", DISCARD: "logStatusDiscard"}[status]
    for word in words:
        assert word in text, text
    assert instance.serialize() == before, "the refused call changed the instance"


def test_the_instance_can_go_on_after_a_refused_call(running):
    vr = (c_uint * 1)(99999)
    refused(running, lambda: running.status("fmi2GetReal", vr, 1, (c_double * 1)()), "99999")
    running.step(1e-3, 1e-3)


@pytest.mark.parametrize("kind, ctype", [("Real", c_double), ("Integer", c_int), ("Boolean", c_int)])
@pytest.mark.parametrize("verb", ["Get", "Set"])
def test_unknown_reference(running, verb, kind, ctype):
    vr, last = (c_uint * 1)(4000), len(running.fmu.variables) - 1
    refused(running, lambda: running.status(f"fmi2{verb}{kind}", vr, 1, (ctype * 1)()), f"fmi2{verb}{kind}", "4000", f"{last}")


def test_wrong_type(running):
    name = REAL_INPUT[running.fmu.identifier]
    vr, value = running.references([name]), (c_int * 1)(1)
    refused(running, lambda: running.status("fmi2GetInteger", vr, 1, value), f"`{name}`", "Integer", "as Real")
    refused(running, lambda: running.status("fmi2SetBoolean", vr, 1, value), f"`{name}`", "Boolean", "as Real")
    refused(running, lambda: running.status("fmi2GetString", vr, 1, (c_char_p * 1)()), f"`{name}`", "String", "as Real")
    refused(running, lambda: running.status("fmi2SetString", vr, 1, (c_char_p * 1)(b"1")), f"`{name}`", "String", "as Real")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_value_that_is_not_finite(running, value):
    name = REAL_INPUT[running.fmu.identifier]
    shown = {"nan": "NaN", "inf": "inf", "-inf": "-inf"}[str(value)]
    refused(running, lambda: running.set({name: value}), f"`{name}` = {shown}", "must be from", status=DISCARD)


def test_a_bad_value_spoils_the_whole_batch(running):
    """Nothing of a batch is written if one of its values is refused."""
    names = running.fmu.names("input")[:3]
    refused(running, lambda: running.set(dict(zip(names, [0.01, 0.02, float("nan")]))), f"`{names[2]}`", status=DISCARD)


def test_parameter_out_of_bounds(fmu):
    """The message says the bounds that the model description declares."""
    name, value = LIMITED[fmu.identifier]
    bounds = [fmu.variables[name].min, fmu.variables[name].max]
    allowed = [format(Decimal(bound).normalize(), "f") for bound in bounds if bound is not None]
    instance = fmu.instance()
    refused(instance, lambda: instance.set({name: value}), f"`{name}` = {value:g}", "must be", *allowed, status=DISCARD)
    instance.free()


def test_input_out_of_bounds(running):
    name = REAL_INPUT[running.fmu.identifier]
    refused(running, lambda: running.set({name: 1e30}), f"`{name}`", "must be from", status=DISCARD)


def test_enumeration_out_of_items(controller):
    instance = controller.instance()
    for value in (0, 12, -1):
        refused(instance, lambda: instance.set({"mode": value}), f"`mode` = {value}", "1 (adaptive) or 2 (modular) or 3 (pd) or 4 (modular_integral)", status=DISCARD)
    instance.free()


def test_setting_an_output(running):
    name = REAL_OUTPUT[running.fmu.identifier]
    refused(running, lambda: running.set({name: 1.0}), f"`{name}` = 1", "output", "only inputs and parameters can")


def test_setting_a_fixed_parameter_after_initialization(running):
    name = FIXED[running.fmu.identifier]
    refused(running, lambda: running.set({name: 1.0}), f"`{name}`", "fixed", "before the end of initialization")


def test_setting_a_file_after_initialization(running):
    refused(running, lambda: running.set({"machine_file": "x.json"}), "`machine_file`", "x.json", "before the end of initialization")


NOT_ALLOWED = {
    "Instantiated": ["fmi2ExitInitializationMode", "fmi2Terminate", "fmi2DoStep", "fmi2GetReal"],
    "Initialization Mode": ["fmi2EnterInitializationMode", "fmi2Terminate", "fmi2DoStep", "fmi2SetupExperiment"],
    "Step Complete": ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2SetupExperiment"],
    "Terminated": ["fmi2EnterInitializationMode", "fmi2Terminate", "fmi2DoStep", "fmi2SetReal", "fmi2SetupExperiment"],
}
ARGUMENTS = {"fmi2DoStep": (0.0, 1e-3, 1), "fmi2SetupExperiment": (0, 0.0, 0.0, 0, 0.0), "fmi2GetReal": (None, 0, None), "fmi2SetReal": (None, 0, None)}  # fmt: skip


@pytest.mark.parametrize("mode", NOT_ALLOWED)
def test_call_out_of_order(fmu, mode):
    for function in NOT_ALLOWED[mode]:
        instance = fmu.instance()
        if mode != "Instantiated":
            instance.setup()
            instance.call("fmi2EnterInitializationMode")
        if mode in ("Step Complete", "Terminated"):
            instance.call("fmi2ExitInitializationMode")
        if mode == "Terminated":
            instance.call("fmi2Terminate")
        call = lambda: instance.status(function, *ARGUMENTS.get(function, ()))
        refused(instance, call, function, f"not allowed in state {mode}", "allowed in")
        instance.free()


@pytest.mark.parametrize("h", [0.0, -1e-3, float("nan"), float("inf"), 1e-300])
def test_wrong_step_size(running, h):
    word = "does not move" if h == 1e-300 else "must be finite and > 0"
    refused(running, lambda: running.step(1e-3, h), "step size", word)


@pytest.mark.parametrize("t", [0.0, 5e-4, 2e-3, -1.0, float("nan"), float("inf")])
def test_jump_in_time(running, t):
    refused(running, lambda: running.step(t, 1e-3), "time =", "must be the present time 0.001 s")


def test_step_past_the_stop_time(fmu):
    instance = fmu.instance().start(stop=2e-3)
    instance.step(0.0, 1e-3)
    refused(instance, lambda: instance.step(1e-3, 1.1e-3), "stop time", "must end by 0.002 s")
    instance.step(1e-3, 1e-3)
    instance.free()


def test_null_arrays_are_fine_only_when_empty(running):
    for kind in ("Real", "Integer", "Boolean", "String"):
        for verb in ("Get", "Set"):
            assert running.status(f"fmi2{verb}{kind}", None, 0, None) == OK
            refused(running, lambda: running.status(f"fmi2{verb}{kind}", None, 2, None), "NULL with 2 elements")
    assert running.status("fmi2SetRealInputDerivatives", None, 0, None, None) == OK
    for name, arguments in [
        ("fmi2GetFMUstate", (None,)),
        ("fmi2SerializedFMUstateSize", (None, None)),
        ("fmi2DeSerializeFMUstate", (None, 8, None)),
        ("fmi2GetStatus", (0, None)),
    ]:
        assert running.status(name, *arguments) == ERROR, name


def test_null_string(fmu):
    instance = fmu.instance()
    vr, null = instance.references(["machine_file"]), (c_char_p * 1)(None)
    refused(instance, lambda: instance.status("fmi2SetString", vr, 1, null), "value[0] = NULL must be a string")
    instance.free()


def test_null_instance_is_an_error(fmu):
    dll = fmu.instance().slave.dll
    assert dll.fmi2DoStep(None, 0.0, 1e-3, 1) == ERROR
    assert dll.fmi2Reset(None) == ERROR
    dll.fmi2FreeInstance(None)


@pytest.mark.parametrize("guid", ["", "nonsense", "{00000000-0000-0000-0000-000000000000}"])
def test_wrong_guid_gives_no_instance(fmu, guid):
    instance = fmu.instance(guid=guid)
    assert not instance.component
    assert f"fmuGUID = {guid}" in instance.text and f"must be {fmu.description.guid}" in instance.text


def test_wrong_kind_and_missing_callbacks_give_no_instance(fmu):
    instance = fmu.instance()
    instantiate, guid = instance.slave.dll.fmi2Instantiate, fmu.description.guid.encode()
    has_exchange = fmu.description.modelExchange is not None
    wrong = 2 if has_exchange else 0
    assert not instantiate(b"x", wrong, guid, None, byref(instance.callbacks), 0, 0)
    assert f"fmuType = {wrong} must be 1 (fmi2CoSimulation)" in instance.text
    assert ("or 0 (fmi2ModelExchange)" in instance.text) == has_exchange
    assert not instantiate(b"x", 1, guid, None, None, 0, 0)
    assert not instantiate(None, 1, guid, None, byref(instance.callbacks), 0, 0)
    assert "instanceName = NULL" in instance.text
    instance.free()


def refuses_file(fmu, parameter, path, content, words):
    """The file of the parameter, of that content or, where it is None, not there, is refused; the instance starts without it."""
    if content is not None:
        path.write_text(content)
    instance = fmu.instance()
    refused(instance, lambda: instance.set({parameter: str(path)}), f"`{parameter}`", str(path), *words)
    instance.start()
    instance.free()


@pytest.mark.parametrize("content, words", [
    (None, ["nowhere.json"]),
    ("", ["EOF"]),
    ("{", ["EOF"]),
    ("[]", ["machine"]),
    ('{"gravity": 9.81, "surprise": 1}', ["surprise"]),
])  # fmt: skip
def test_wrong_machine_file(fmu, tmp_path, content, words):
    refuses_file(fmu, "machine_file", tmp_path / "nowhere.json", content, words)


def machine_with(fmu, field, number, folder):
    """A file of the reference machine with another number in the fields of that name."""
    text = Path(fmu.folder, "resources/reference_machine.json").read_text()
    path = folder / "machine.json"
    path.write_text(re.sub(rf'"{field}": [\d.]+', f'"{field}": {number}', text))
    return str(path)


def test_machine_file_with_an_impossible_number(fmu, tmp_path):
    file = machine_with(fmu, "R_s", -1, tmp_path)
    instance = fmu.instance()
    refused(instance, lambda: instance.set({"machine_file": file}), "R_s", "-1")
    instance.free()


def test_start_outside_the_joint_limits(hdrm):
    instance = hdrm.instance()
    instance.set({"zeta_start[3]": 0.5})
    instance.setup()
    instance.call("fmi2EnterInitializationMode")
    refused(instance, lambda: instance.call("fmi2ExitInitializationMode"), "`zeta_start[3]` = 0.5 rad", "joint limits [")
    instance.set({"zeta_start[3]": -1.0})
    instance.call("fmi2ExitInitializationMode")
    instance.free()


def test_foreign_and_freed_states(running):
    foreign = c_void_p(12345)
    refused(running, lambda: running.status("fmi2SetFMUstate", foreign), "not a saved state of this instance", "it must be")
    state = running.save()
    kept = c_void_p(state.value)
    running.slave.freeFMUstate(state)
    refused(running, lambda: running.status("fmi2SetFMUstate", kept), "freed")
    refused(running, lambda: running.status("fmi2FreeFMUstate", byref(kept)), "freed")


def damages(data):
    """(bytes, words of the message) for each way to spoil a serialized state."""
    flipped = bytearray(data)
    flipped[len(data) // 2] ^= 0x10
    return {
        "empty": (b"", "has 0 bytes"),
        "foreign": (b"somebody else's state" + data[21:], "from elsewhere"),
        "other version": (data[:8] + b"\xff" + data[9:], "format version"),
        "FMI 3.0": (data[:12] + b"3.0\0" + data[16:], "of an instance of FMI 3.0; it must be of FMI 2.0"),
        "other FMU": (data[:16] + bytes(16) + data[32:], "of the model {00000000-0000-0000-0000-000000000000}; it must be of"),
        "cut": (data[:-1], "truncated"),
        "flipped bit": (bytes(flipped), "damaged: checksum"),
        "huge length": (data[:32] + b"\xff" * 8 + data[40:], "truncated"),
    }


@pytest.mark.parametrize("damage", damages(bytes(100)))
def test_damaged_serialized_state(running, damage):
    data, words = damages(running.serialize())[damage]
    state, buffer = c_void_p(), create_string_buffer(data, max(len(data), 1))
    refused(running, lambda: running.status("fmi2DeSerializeFMUstate", buffer, len(data), byref(state)), words)
    assert state.value is None


def test_no_single_flipped_byte_is_accepted(hdrm):
    """A burst over the whole state: every byte changed in turn is found by header or checksum."""
    instance = hdrm.running()
    data = instance.serialize()
    for i in range(0, len(data), 7):
        spoilt = data[:i] + bytes([data[i] ^ 0xFF]) + data[i + 1 :]
        buffer, state = create_string_buffer(spoilt, len(spoilt)), c_void_p()
        assert instance.status("fmi2DeSerializeFMUstate", buffer, len(spoilt), byref(state)) == ERROR, i
    instance.free()


def test_serializing_into_too_little_room(running):
    state, size = running.save(), c_size_t()
    running.call("fmi2SerializedFMUstateSize", state, byref(size))
    buffer = create_string_buffer(size.value)
    call = lambda: running.status("fmi2SerializeFMUstate", state, buffer, size.value - 1)
    refused(running, call, f"size = {size.value - 1}", f"at least {size.value}")
    running.slave.freeFMUstate(state)


def test_input_derivatives_of_what_has_none(running):
    name, output = REAL_INPUT[running.fmu.identifier], REAL_OUTPUT[running.fmu.identifier]
    refused(running, lambda: running.set_derivatives({output: 1.0}), f"`{output}`", "must be a continuous Real input")
    refused(running, lambda: running.set_derivatives({name: 1.0}, order=0), f"`{name}`", "= 0 must be at least 1")
    refused(running, lambda: running.set_derivatives({name: float("nan")}), f"`{name}`", "NaN must be finite", status=DISCARD)
    running.set_derivatives({name: 1.0}, order=99)  # FMI 2.0 declares no highest order: left out


def test_output_derivatives_of_what_has_none(fmu, running):
    name, output = REAL_INPUT[fmu.identifier], REAL_OUTPUT[fmu.identifier]
    if fmu.identifier == "Controller":
        refused(running, lambda: running.derivatives(output), "maxOutputDerivativeOrder = 0")
        refused(running, lambda: running.directional([output], {name: 1.0}), "providesDirectionalDerivative = false")
    else:
        refused(running, lambda: running.derivatives(name), f"`{name}`", "must be a Real output")
        refused(running, lambda: running.directional([output], {output: 1.0}), f"`{output}`", "must be a Real input")
        refused(running, lambda: running.directional([output], {name: float("inf")}), f"`{name}`", "inf must be finite", status=DISCARD)


def test_debug_logging(fmu):
    """Categories that are not declared are ignored; errors are reported whatever is switched off."""
    instance = fmu.instance(logging=True)
    names = (c_char_p * 2)(b"logGossip", b"logNonlinearSystems")
    instance.call("fmi2SetDebugLogging", 1, 0, None)
    instance.call("fmi2SetDebugLogging", 0, 2, names)
    instance.start()
    assert [m[2] for m in instance.messages].count("logEvents") == 1
    instance.call("fmi2SetDebugLogging", 0, 0, None)
    count = len(instance.messages)
    assert instance.status("fmi2DoStep", 0.0, -1.0, 1) == ERROR
    assert [m[2] for m in instance.messages[count:]] == ["logStatusError"]
    vr, nan = instance.references([REAL_INPUT[fmu.identifier]]), (c_double * 1)(float("nan"))
    assert instance.status("fmi2SetReal", vr, 1, nan) == DISCARD
    assert len(instance.messages) == count + 1, "a message of fmi2Discard came though logging is off"
    instance.free()


def test_refusals_without_a_logger(fmu):
    instance = fmu.instance(callbacks=False)
    assert instance.status("fmi2DoStep", 0.0, 1e-3, 1) == ERROR
    instance.start()
    instance.free()


@pytest.mark.parametrize("arguments, words", [
    ((0, 0.0, float("inf"), 0, 0.0), ["start time = inf s must be finite"]),
    ((0, 0.0, 2.0, 1, 1.5), ["stop time = 1.5 s must be at least the start time = 2 s"]),
    ((0, 0.0, 2.0, 1, float("nan")), ["stop time = NaN s", "start time = 2 s"]),
])  # fmt: skip
def test_experiment_without_sense(fmu, arguments, words):
    instance = fmu.instance()
    given, tolerance, start, stops, stop = arguments
    refused(instance, lambda: instance.status("fmi2SetupExperiment", given, c_double(tolerance), c_double(start), stops, c_double(stop)), *words)
    instance.free()


def test_experiment_without_limits(fmu):
    """No stop time may be written as infinity; the tolerance is for FMUs that control their error."""
    for tolerance in (0.0, -1.0, float("nan")):
        instance = fmu.instance()
        instance.call("fmi2SetupExperiment", 1, c_double(tolerance), c_double(0.0), 1, c_double(float("inf")))
        instance.free()


@pytest.mark.parametrize("function, kind, place, word", [
    ("fmi2GetStatus", 1, c_int, "must be 0 (fmi2DoStepStatus)"),
    ("fmi2GetRealStatus", 0, c_double, "must be 2 (fmi2LastSuccessfulTime)"),
    ("fmi2GetIntegerStatus", 2, c_int, "no Integer status"),
    ("fmi2GetBooleanStatus", 1, c_int, "must be 3 (fmi2Terminated)"),
    ("fmi2GetStringStatus", 7, c_char_p, "must be 1 (fmi2PendingStatus)"),
])  # fmt: skip
def test_inquiry_of_the_wrong_kind(running, function, kind, place, word):
    """FMI 2.0.4, section 4.2.3: fmi2Discard where there is no answer."""
    refused(running, lambda: running.status(function, kind, byref(place())), f"status kind = {kind}", word, status=DISCARD)


def test_cancelling_what_is_not_in_progress(running):
    refused(running, lambda: running.status("fmi2CancelStep"), "fmi2CancelStep", "steps are synchronous")


def test_string_that_is_no_text(fmu):
    instance = fmu.instance()
    vr = instance.references(["machine_file"])
    refused(instance, lambda: instance.status("fmi2SetString", vr, 1, (c_char_p * 1)(b"\xff\xfe.json")), "UTF-8")
    instance.free()


def test_unnamed_instance(fmu):
    instance = fmu.instance()
    instantiate, guid = instance.slave.dll.fmi2Instantiate, fmu.description.guid.encode()
    assert not instantiate(b"", 1, guid, None, byref(instance.callbacks), 0, 0)
    assert "instanceName is empty; it must be a name" in instance.text
    instance.free()


@pytest.mark.parametrize("content, words", [
    (None, ["nowhere.json"]),
    ("{}", ["missing field"]),
    ('{"surprise": 1}', ["surprise", "expected one of"]),
])  # fmt: skip
@pytest.mark.parametrize("fmu", ["Emla", "Controller"], indirect=True)
def test_wrong_surrogate_file(fmu, tmp_path, content, words):
    refuses_file(fmu, "surrogate_file", tmp_path / "nowhere.json", content, words)


def test_machine_that_cannot_be_assembled(hdrm, tmp_path):
    """Each number is allowed, together they are no mechanism: the message says where it does not close, and what would."""
    instance = hdrm.instance()
    instance.set({"machine_file": machine_with(hdrm, "d4", 0.05, tmp_path)})
    instance.setup()
    instance.call("fmi2EnterInitializationMode")
    words = ["the four-bar does not close at zeta_3 = ", "|AC| must lie between"]
    refused(instance, lambda: instance.call("fmi2ExitInitializationMode"), *words)
    instance.free()


@pytest.mark.parametrize("fmu", ["Emla", "Hdrm"], indirect=True)
def test_derivative_of_an_order_that_is_not_provided(fmu, running):
    name, value, order = REAL_OUTPUT[fmu.identifier], (c_double * 1)(), (c_int * 1)(2)
    call = lambda: running.status("fmi2GetRealOutputDerivatives", running.references([name]), 1, order, value)
    refused(running, call, f"`{name}`", "order of derivative = 2 must be 1")


def test_derivatives_that_carry_an_input_out_of_bounds(hdrm):
    instance = hdrm.running()
    instance.set({"f[2]": 9e6})
    instance.set_derivatives({"f[2]": 1e9})
    refused(instance, lambda: instance.step(0.0, 1e-2), "`f[2]`", "to 19000000; it must be from", status=DISCARD)
    instance.step(0.0, 5e-4)
    instance.free()


def test_step_that_would_take_for_ever(fmu, running):
    refused(running, lambda: running.step(1e-3, 1e5), "h = 100000 s", "at most", status=DISCARD)
    running.step(1e-3, 1e-3)


def test_orientation_without_length(controller):
    instance = controller.instance()
    instance.set({"trajectory": 3})
    instance.start()
    instance.set({f"reference.orientation[{i}]": 0.0 for i in range(1, 5)})
    words = ["`reference.orientation` has length 0", "must be a quaternion of length 1"]
    refused(instance, lambda: instance.get("v_q[1]"), *words)
    refused(instance, lambda: instance.step(0.0, 1e-3), *words, status=DISCARD)
    instance.free()


def test_motion_out_of_all_proportion(hdrm):
    """Joint friction too stiff for the shortest substep on a machine of a hundredth of the inertia: the step is refused, the
    outputs stay numbers."""
    instance = hdrm.instance()
    instance.set({"joint_viscous[6]": 1e6, "inertia_scale": 0.01, "zeta_dot_start[6]": 0.1})
    instance.start()
    refused(instance, lambda: instance.step(0.0, 1e-2), "`zeta", "became", "its magnitude must be at most 1e9", status=DISCARD)
    assert instance.get("zeta_dot[6]") == 0.1
    instance.free()
