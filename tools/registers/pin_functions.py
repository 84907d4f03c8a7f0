# SPDX-License-Identifier: Apache-2.0
"""Functions of the pins and numbers of the DMA requests, from the crate `stm32g4xx-hal`; and our own pin table."""

import pathlib
import re

ANALOG = -1


def _timer_pins(text: str) -> dict[tuple[str, str], int]:
    """Sections "TIM1: CH1(...): [ gpio::PA8<AF6>, ..." of pwm.rs."""
    functions = {}
    timer = channel = ""
    for line in text.splitlines():
        if found := re.match(r"\s+(TIM\d+|HRTIM\w*):$", line):
            timer = found[1]
        elif found := re.match(r"\s+(\w+)(?:\(\w+\))?: \[", line):
            channel = found[1]
        if timer:
            for pin, function in re.findall(r"gpio::(P[A-G]\d+)<AF(\d+)>", line):
                functions[pin, f"{timer}_{channel}"] = int(function)
    return functions


def _serial_pins(text: str, start: str) -> dict[tuple[str, str], int]:
    """Sections "spi!( SPI1, ... sck: [ PA5<AF5>, ..." and "uart_shared!(USART1, ... tx: [ (PA9, AF7), ..."."""
    functions = {}
    block = line_name = ""
    for line in text.splitlines():
        if found := re.match(rf"(?:\s+|{start}!\()((?:SPI|USART)\d),", line):
            block = found[1]
        if found := re.match(r"\s*(sck|miso|mosi|tx|rx): \[", line):
            line_name = found[1].upper()
        for pin, function in re.findall(r"\(?(P[A-G]\d+)(?:<|, )AF(\d+)", line):
            if block and line_name:
                functions[pin, f"{block}_{line_name}"] = int(function)
    return functions


def _can_pins(text: str) -> dict[tuple[str, str], int]:
    """Per controller a list of transmit pins, then one of receive pins."""
    functions = {}
    section = re.search(r"mod fdcan1 \{(.*?)^\}", text, re.DOTALL | re.MULTILINE)[1]
    lists = re.findall(r"(?:tx|rx|Tx|Rx|TX|RX)?:? ?\[([^\]]*)\]", section)
    lists = [entry for entry in lists if "<AF" in entry]
    for name, entry in zip(("FDCAN1_TX", "FDCAN1_RX"), lists):
        for pin, function in re.findall(r"(P[A-G]\d+)<AF(\d+)>", entry):
            functions[pin, name] = int(function)
    return functions


def read_functions(folder: pathlib.Path) -> dict[tuple[str, str], int]:
    """Alternate function number by pin and signal, ANALOG for a converter's input."""
    functions = _timer_pins((folder / "pwm.rs").read_text("utf-8"))
    functions |= _serial_pins((folder / "spi.rs").read_text("utf-8"), "spi")
    functions |= _serial_pins((folder / "usart.rs").read_text("utf-8"), "uart_shared")
    functions |= _can_pins((folder / "can.rs").read_text("utf-8"))
    for pin, converter, channel in re.findall(r"gpio[a-g]::(P[A-G]\d+)<Analog> => \((ADC\d), (\d+)\)",
                                              (folder / "g4.rs").read_text("utf-8")):
        functions[pin, f"{converter}_IN{channel}"] = ANALOG
    return functions


def read_dma_requests(folder: pathlib.Path) -> dict[str, int]:
    text = (folder / "mux.rs").read_text("utf-8")
    return {name: int(number) for name, number in re.findall(r"^\s+(\w+) = (\d+),$", text, re.MULTILINE)}


def read_our_pins(source: pathlib.Path) -> dict[str, int]:
    """Of pins.c: alternate function by pin, ANALOG for analog ones; plain outputs are left out."""
    rows = re.findall(r"\{GPIO([A-G]), (\d+), (ALTERNATE|ANALOG), (\d+),", source.read_text("utf-8"))
    return {f"P{port}{pin}": int(function) if mode == "ALTERNATE" else ANALOG for port, pin, mode, function in rows}
