# SPDX-License-Identifier: Apache-2.0
"""The image's own tools, and the built image: version block, vectors, and what the budget detects."""

import pathlib
import re
import struct
import subprocess
import sys
import tomllib
import zlib

import pytest

import budget
import call_graph
import stamp_image

PROJECT = pathlib.Path(__file__).resolve().parents[3]
IMAGE = PROJECT / "build/stm32g474/bin/trackservo"


@pytest.fixture(scope="session")
def image() -> bytes:
    return IMAGE.with_suffix(".bin").read_bytes()


@pytest.fixture(name="compiled")
def fixture_compiled(tmp_path: pathlib.Path):
    """Compiles a little program for the board's core."""
    def compiled(source: str) -> pathlib.Path:
        elf = tmp_path / "program.elf"
        (tmp_path / "program.c").write_text(source, "utf-8")
        subprocess.run(["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-O1", "-g", "-fno-inline", "-fno-optimize-sibling-calls",
                        "-nostdlib", "-fstack-usage", "-Wl,-e,root", "-o", elf, tmp_path / "program.c"],
                       check=True, cwd=tmp_path)
        return elf
    return compiled


def depth(elf: pathlib.Path, table: dict[str, list[str]] | None = None) -> tuple[int, list[str]]:
    functions = call_graph.read_functions(elf)
    call_graph.resolve_pointers(elf, functions, table or {})
    root = next(address for address, function in functions.items() if function.name == "root")
    return call_graph.deepest_path(functions, root)


def test_version_block_reports_length_and_crc(image):
    magic, form, length, crc = struct.unpack_from("<IIII", image, 0x200)
    assert (magic, form, length) == (0x56535354, 1, len(image))
    assert crc == zlib.crc32(image[:0x20C] + image[0x210:])


def test_version_block_names_version_commit_and_board(image):
    version, git, _, board = struct.unpack_from("<16s48sI12s", image, 0x210)
    stated = re.search(r"VERSION (\d+\.\d+\.\d+)", (PROJECT / "CMakeLists.txt").read_text("utf-8"))[1]
    assert version.rstrip(b"\0").decode() == stated
    assert re.fullmatch(r"[0-9a-z.-]{4,47}", git.rstrip(b"\0").decode())
    assert board.rstrip(b"\0") == b"nucleo_g474"


def test_vectors_lead_where_the_chip_looks(image):
    names = call_graph.read_symbols(IMAGE.with_suffix(".elf"))
    stack, *vectors = struct.unpack_from("<118I", image, 0)
    assert 0x20000000 < stack <= 0x20018000 and stack % 8 == 0
    assert all(vector & 1 for vector in vectors)
    expected = {1: "reset_handler", 2: "nmi_handler", 16 + 18: "adc1_2_interrupt", 16 + 21: "fdcan1_it0_interrupt",
                16 + 24: "tim1_brk_interrupt", 16 + 43: "tim8_brk_interrupt", 16 + 54: "tim6_dac_interrupt",
                14: "pendsv_exception", 16 + 55: "pre_tick_interrupt"}
    for number, vector in enumerate(vectors, start=1):
        assert names[vector & ~1] == expected.get(number, "fault_handler"), number


CCM = range(0x10000000, 0x10008000)


def test_frequent_interrupts_run_in_ram_and_fault_handlers_in_flash():
    address_of = {name: address for address, name in call_graph.read_symbols(IMAGE.with_suffix(".elf")).items()}
    for name in ("adc1_2_interrupt", "tim1_brk_interrupt", "tim8_brk_interrupt", "tim6_dac_interrupt"):
        assert address_of[name] in CCM, name
    for name in ("reset_handler", "start_image", "fault_handler", "handle_fault", "nmi_handler", "pendsv_exception"):
        assert address_of[name] not in CCM, name


def test_a_jump_made_by_the_linker_counts_as_a_call_to_its_target():
    functions = call_graph.read_functions(IMAGE.with_suffix(".elf"))
    names = {callee: functions[callee].name for function in functions.values() for callee in function.calls}
    assert not [name for name in names.values() if name.endswith("_veneer")]
    far = [caller for address, caller in functions.items() if address not in CCM and not caller.name.endswith("_veneer")
           and any(callee in CCM for callee in caller.calls)]
    assert far, "no function in flash calls one in RAM"


# Where the firmware calls each kind of hook.
CALLERS = {"refresh": "od_read", "accept": "od_check_write", "execute": "object_dictionary.c:execute", "changed": "od_write_checked",
           "stops": "od_is_stop", "defer": "od_defer_stop", "waits": "od_must_wait", "needed": "od_needed_hooks", "stream_begin": "sdo_transfer.c:begin_stream",
           "stream_read": "sdo_transfer_read", "stream_append": "sdo_transfer_append", "stream_end": "sdo_transfer.c:end_stream"}


def test_every_hook_of_the_dictionary_counts_for_the_stack():
    table = tomllib.loads((PROJECT / "tools/image/indirect_calls.toml").read_text("utf-8"))
    found = 0
    for file in sorted((PROJECT / "firmware").rglob("*.c")):
        hooks = [] if file.parent.name == "tests" else re.findall(r"od_hooks \w+ = \{([^}]*)\}", file.read_text("utf-8"))
        for kind, function in re.findall(r"\.(\w+) = (\w+)", " ".join(hooks)):
            found += 1
            assert f"{file.name}:{function}" in table[CALLERS[kind]]["calls"], f"{file.name}: {kind}"
    assert found >= 20


def test_hex_and_elf_hold_the_same_bytes(image, tmp_path):
    for kind, form in (("hex", "ihex"), ("elf", "elf32-littlearm")):
        subprocess.run(["arm-none-eabi-objcopy", "-I", form, "-O", "binary", IMAGE.with_suffix(f".{kind}"), tmp_path / kind],
                       check=True)
        assert (tmp_path / kind).read_bytes() == image, kind


def test_an_image_without_version_block_is_refused():
    with pytest.raises(ValueError, match="no version block"):
        stamp_image.stamped(bytes(4096))


def test_stack_is_the_sum_along_the_deepest_calls(compiled):
    elf = compiled("""
        void use(volatile char *p) { *p = 1; }
        void deep(void) { volatile char a[200]; use(a); }
        void flat(void) { volatile char a[8]; use(a); }
        void root(void) { flat(); deep(); flat(); }
    """)
    usage = {line.split("\t")[0].rsplit(":", 1)[1]: int(line.split("\t")[1])
             for line in next(elf.parent.glob("*.su")).read_text("utf-8").splitlines()}
    assert depth(elf) == (usage["root"] + usage["deep"] + usage["use"], ["root", "deep", "use"])


def test_recursion_is_found(compiled):
    elf = compiled("""
        int even(int n); int odd(int n) { return n ? even(n - 1) + 1 : 0; }
        int even(int n) { return n ? odd(n - 1) + 2 : 1; }
        int root(int n) { return even(n); }
    """)
    with pytest.raises(call_graph.CallGraphError, match="recursion: even -> odd|recursion: odd -> even"):
        depth(elf)


POINTER = """
    typedef void (*hook)(void); hook chosen;
    __attribute__((used)) void taken(void) { volatile char a[100]; a[0] = 1; }
    void root(void) { chosen(); }
"""


def test_a_call_through_a_pointer_must_be_named(compiled):
    with pytest.raises(call_graph.CallGraphError, match="root calls through a pointer"):
        depth(compiled(POINTER))


def test_a_named_call_through_a_pointer_counts(compiled):
    total, path = depth(compiled(POINTER), {"root": ["taken"]})
    assert path == ["root", "taken"] and total >= 100


def test_a_name_for_no_call_is_refused(compiled):
    with pytest.raises(call_graph.CallGraphError, match="no call through a pointer in taken"):
        depth(compiled(POINTER), {"root": ["taken"], "taken": []})


def test_a_call_through_a_pointer_is_of_the_function_in_the_source_that_makes_it(compiled):
    elf = compiled("""
        extern void (*hook)(void);
        void target(void) {}
        __attribute__((always_inline)) static inline void inner(void) { hook(); }
        int root(void) { inner(); return 1; }
        void (*hook)(void) = target;
    """)
    assert depth(elf, {"program.c:inner": ["target"]})[1] == ["root", "target"]
    with pytest.raises(call_graph.CallGraphError, match="program.c:inner calls through a pointer"):
        depth(elf, {"root": ["target"]})


def test_a_stack_of_unknown_size_is_refused(compiled):
    elf = compiled("void use(char *); void root(int n) { char a[n]; use(a); } void use(char *p) { __asm volatile(\"\" :: \"r\"(p) : \"memory\"); }")
    with pytest.raises(call_graph.CallGraphError, match="the stack frame has an unknown size"):
        budget.read_stack_usage(elf.parent)


def test_a_heap_is_found(compiled):
    elf = compiled("void *malloc(unsigned n) { static char a[9]; return a + n; } void *root(void) { return malloc(3); }")
    assert budget.heap_symbols(elf) == ["malloc"]
    assert budget.heap_symbols(IMAGE.with_suffix(".elf")) == []


def test_the_image_keeps_its_budget():
    result = subprocess.run([sys.executable, PROJECT / "tools/image/budget.py", IMAGE.with_suffix(".elf"), "--stack-usage",
                             PROJECT / "build/stm32g474", "--pointers", PROJECT / "tools/image/indirect_calls.toml"],
                            check=False, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_more_than_the_budget_is_reported(monkeypatch, capsys):
    monkeypatch.setattr(budget, "FLASH_BUDGET", 1024)
    monkeypatch.setattr(sys, "argv", ["budget.py", str(IMAGE.with_suffix(".elf")), "--stack-usage",
                                      str(PROJECT / "build/stm32g474"), "--pointers",
                                      str(PROJECT / "tools/image/indirect_calls.toml")])
    assert budget.main() == 1
    assert re.search(r"flash .* OVER", capsys.readouterr().out)


@pytest.mark.parametrize("runner, action, sentence", [
    ("openocd", "fly", "unknown action 'fly' for runner 'openocd'"),
    ("dfu", "change", "unknown action 'change' for runner 'dfu'"),  # a function of the script
    ("dfu", "debug", "the boot loader cannot debug"),
])
def test_what_cannot_be_done_with_the_board_is_said_in_one_sentence(runner, action, sentence):
    result = subprocess.run([PROJECT / "tools/image/board", runner, action, IMAGE], check=False, capture_output=True, text=True)
    assert result.returncode == 1 and sentence in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.parametrize("runner, program", [("openocd", "openocd"), ("stlink", "st-flash"), ("dfu", "dfu-util")])
@pytest.mark.parametrize("there", [True, False])
def test_a_missing_program_or_board_is_said_in_one_sentence(runner, program, there, tmp_path):
    """A program of that name that finds no board, or no such program."""
    (tmp_path / "python3").symlink_to(pathlib.Path(sys.executable).resolve())
    for tool in ("bash", "dirname", "mkdir", "grep", "rm"):
        found = subprocess.run(["bash", "-c", f"command -v {tool}"], check=True, capture_output=True, text=True).stdout.strip()
        (tmp_path / tool).symlink_to(found)
    if there:
        (tmp_path / program).write_text("#!/bin/sh\necho 'Error: open failed, No DFU capable device, no stlink' >&2\nexit 1\n")
        (tmp_path / program).chmod(0o755)
    result = subprocess.run([PROJECT / "tools/image/board", runner, "flash", IMAGE], check=False, capture_output=True, text=True,
                            env={"PATH": str(tmp_path)})
    expected = "no board was found" if there else f"{program} is not installed"
    assert result.returncode == 1 and expected in result.stderr and result.stderr.count("\n") == 1, result.stderr
