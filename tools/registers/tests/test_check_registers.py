# SPDX-License-Identifier: Apache-2.0
"""The check of the registers accepts the headers as they are, and finds errors put into them."""

import pathlib
import shutil
import subprocess
import sys

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[3]
CHIP = PROJECT / "hal/chips/stm32g4"
PINS = PROJECT / "hal/boards/nucleo_g474/pins.c"


def check(chip: pathlib.Path, pins: pathlib.Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, PROJECT / "tools/registers/check_registers.py", "--headers", chip / "registers",
                           "--pins", pins], check=False, capture_output=True, text=True)


@pytest.fixture(name="board")
def fixture_board(tmp_path: pathlib.Path) -> pathlib.Path:
    board = tmp_path / "board"
    shutil.copytree(CHIP / "registers", board / "registers")
    for file in (CHIP / "interrupts.h", PINS):
        shutil.copy(file, board)
    return board


def test_all_definitions_agree():
    result = check(CHIP, PINS)
    assert result.returncode == 0, result.stdout
    assert int(result.stdout.split()[0]) > 500


@pytest.mark.parametrize("file, right, wrong, error", [
    ("registers/rcc.h", "RCC_CR_HSEON FIELD(16, 1)", "RCC_CR_HSEON FIELD(17, 1)", "RCC_CR_HSEON"),
    ("registers/timer.h", "TIM1_BDTR_DTG FIELD(0, 8)", "TIM1_BDTR_DTG FIELD(0, 7)", "TIM1_BDTR_DTG"),
    ("registers/rcc.h", "RCC_AHB1ENR_RESET 0x00000100u", "RCC_AHB1ENR_RESET 0x00000000u", "RCC_AHB1ENR_RESET"),
    ("registers/iwdg.h", "IWDG_RLR_RESET 0x00000FFFu", "IWDG_RLR_RESET 0x000007FFu", "IWDG_RLR_RESET"),
    ("registers/spi.h", "volatile uint32_t cr2;", "uint32_t reserved_04;\n  volatile uint32_t cr2;", "offset"),
    ("registers/dma.h", "uint32_t reserved_10;", "uint32_t reserved_10[2];", "0x14"),
    ("registers/usart.h", "0x40013800u", "0x40013C00u", "USART1 address"),
    ("registers/adc.h", "ADC1_JEXTSEL_TIM1_TRGO2 = 8", "ADC1_JEXTSEL_TIM1_TRGO2 = 9", "ADC1_JEXTSEL_TIM1_TRGO2"),
    ("registers/dma.h", "DMAMUX_SPI3_RX = 14", "DMAMUX_SPI3_RX = 15", "DMAMUX_SPI3_RX"),
    ("registers/core.h", "uint32_t reserved_1a0[88];", "uint32_t reserved_1a0[87];", "ipr"),
    ("registers/fdcan.h", "ELEMENT_LENGTH FIELD(16, 4)", "ELEMENT_LENGTH FIELD(20, 4)", "ELEMENT_LENGTH"),
    ("registers/pwr.h", "#define PWR_SR2_VOSF", "#define PWR_SR2_NEW FIELD(1, 1)\n#define PWR_SR2_VOSF", "PWR_SR2_NEW"),
    ("interrupts.h", "TIM8_BRK_INTERRUPT = 43", "TIM8_BRK_INTERRUPT = 44", "TIM8_BRK_INTERRUPT"),
    ("pins.c", "{GPIOB, 3, ALTERNATE, 5,", "{GPIOB, 3, ALTERNATE, 6,", "PB3 as SPI1_SCK"),
    ("pins.c", "{GPIOC, 1, ANALOG, 0,", "{GPIOC, 2, ANALOG, 0,", "PC2"),
])
def test_what_is_put_wrong_is_found(board, file, right, wrong, error):
    path = board / file
    text = path.read_text("utf-8")
    assert text.count(right) == 1
    path.write_text(text.replace(right, wrong), "utf-8")
    result = check(board, board / "pins.c")
    assert result.returncode != 0
    assert error in result.stdout + result.stderr
