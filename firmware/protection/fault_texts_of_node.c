/* SPDX-License-Identifier: Apache-2.0 */
/* Texts of the faults of the node: bus, processor and memory, safety path, parameter store, camera. */
#include "protection/fault_phrases.h"

#define IN_OPERATION "While the node is operational."
#define OPERATIONAL_AND_RESET "Set the node operational (NMT 01), then fault reset."
#define BEFORE_RESET "Note what master and machine did just before the reset. Does the fault return?"

const fault_text fault_texts_of_node[FAULT_COUNT] = {
    [FAULT_HEARTBEAT_LOST] = {.name = "heartbeat lost",
                              .detection =
                                  "A node listed in 1016 sent no heartbeat for longer than the time in its entry.",
                              .when = "From its first heartbeat on.",
                              .timer = "1016",
                              .cause = "The master was stopped, hangs, or is off the bus.",
                              .check =
                                  "Are its heartbeats (identifier 700 + node id) on the bus, and are they regular?",
                              .cure = "Restart the master, or allow more time in 1016.",
                              .clear = OPERATIONAL_AND_RESET},
    [FAULT_RPDO_LATE] = {.name = "set-points late",
                         .detection = "An RPDO did not arrive within its event timer (1400:5, 1401:5 and so on).",
                         .when = IN_OPERATION,
                         .timer = "1400:5",
                         .cause = "The master stopped sending, or sends less often than the timer expects.",
                         .check = "Measure the period of the RPDO on the bus.",
                         .cure = "Restart the master, or set the timer to several periods of the RPDO.",
                         .clear = OPERATIONAL_AND_RESET},
    [FAULT_NODE_STOPPED] = {.name = "node stopped",
                            .detection = "NMT stop, or a reset of the communication while an axis had torque.",
                            .when = ALWAYS,
                            .timer = "",
                            .cause = "A master stopped or reset the node.",
                            .check =
                                "Record the frames with identifier 000: they show which NMT command the master sent.",
                            .cure = "Set the node operational (NMT 01).",
                            .clear = OPERATIONAL_AND_RESET},
    [FAULT_BUS_OFF] =
        {.name = "bus-off",
         .detection = "The CAN controller went bus-off.",
         .when = ALWAYS,
         .timer = "",
         .cause = "The bus is wired or terminated wrongly, or a node uses another bit rate.",
         .check = "Measure 60 ohm between the two bus wires with all power off. Compare the bit rates of all nodes.",
         .cure = "Repair the bus. The node rejoins it without a restart.",
         .clear = OPERATIONAL_AND_RESET},
    [FAULT_TICK_LATE] = {.name = "control task late",
                         .detection = "A control tick was missing, or was not finished within its PWM period.",
                         .when = ALWAYS,
                         .timer = "",
                         .cause = "Interrupts were blocked for too long, or a clock failed.",
                         .check = "Note which commands the master sent just before the fault.",
                         .cure = "Report the fault with its fault log.",
                         .clear = "Restart of the board; its watchdog does this."},
    [FAULT_SELF_TEST] =
        {.name = "self-test failed",
         .owner = FAULT_OF_BOARD,
         .detection = "A start-up test failed. Detail 00 means the RAM, else the detail is a sum: 01 image CRC, 02 "
                      "clock, 04 current offset, 08 azimuth encoder, 10 pitch encoder, 20 azimuth gyro, 40 pitch gyro, "
                      "80 ADC, CAN or watchdog.",
         .when = "At start-up (the axes do not become ready), and in operation when the board is no longer ready.",
         .timer = "",
         .cause =
             "That part is not connected, has no supply, or is dead. Detail 01: the image was written incompletely.",
         .check = "Check connection and supply of the part that the detail names.",
         .cure = "Repair or replace the part. Detail 01: flash the image again.",
         .clear = "Restart of the board."},
    [FAULT_WATCHDOG_RESET] = {.name = "watchdog reset",
                              .owner = FAULT_OF_BOARD,
                              .reported_once = true,
                              .detection = "The board restarted because its watchdog was not refreshed.",
                              .when = "At start-up.",
                              .timer = "",
                              .cause = "The control tick, the current loop or the background task stopped running.",
                              .check = BEFORE_RESET,
                              .cure = "Report the fault with its fault log.",
                              .clear = NOTHING},
    [FAULT_EXCEPTION_RESET] = {.name = "exception reset",
                               .owner = FAULT_OF_BOARD,
                               .reported_once = true,
                               .detection =
                                   "The board restarted after a processor exception. Its number is the upper digit of "
                                   "the detail: 2 NMI, 3 HardFault, 4 MemManage, 5 BusFault, 6 UsageFault.",
                               .when = "At start-up.",
                               .timer = "",
                               .cause = "An error in the firmware, damaged memory, or a stopped clock (NMI).",
                               .check = BEFORE_RESET,
                               .cure = "Report the fault with its detail.",
                               .clear = NOTHING},
    [FAULT_BROWN_OUT_RESET] = {.name = "brown-out reset",
                               .owner = FAULT_OF_BOARD,
                               .reported_once = true,
                               .detection =
                                   "The board restarted after a dip of its supply that was too short to clear the RAM.",
                               .when = "At start-up.",
                               .timer = "",
                               .cause = "The supply is too weak, or a contact of it is loose.",
                               .check = "Measure the 3.3 V supply. Check its plug.",
                               .cure = "Repair the supply or its plug.",
                               .clear = NOTHING},
    [FAULT_IMAGE_DAMAGED] =
        {.name = "image corrupted",
         .detection = "The background check computed a CRC of the program memory that differs from the image's own.",
         .when = "Always. One pass over the image takes about 5 s.",
         .timer = "",
         .cause = "The flash memory loses bits.",
         .check = "Does the self-test of the next start fail as well (fault 29, detail 01)?",
         .cure = "Flash the image again. Replace the board if the fault returns.",
         .clear = "Restart with an intact image."},
    [FAULT_STACK_OVERFLOW] =
        {.name = "stack overflow",
         .owner = FAULT_OF_BOARD,
         .reported_once = true,
         .detection = "The program wrote below its stack. The bridges are switched off at once and the board restarts.",
         .when = "Always. It is reported after the restart.",
         .timer = "",
         .cause = "An error in the firmware.",
         .check = BEFORE_RESET,
         .cure = "Report the fault with its fault log.",
         .clear = NOTHING},
    [FAULT_RAM_PARITY] =
        {.name = "RAM parity error",
         .owner = FAULT_OF_BOARD,
         .reported_once = true,
         .detection = "A word of RAM with a wrong parity was read. The hardware switches the bridges off at once and "
                      "the board restarts.",
         .when = "Always, if the option bit of the chip enables the parity. It is reported after the restart.",
         .timer = "",
         .cause = "A bit of the RAM has flipped (radiation, a disturbance of the supply), or a cell is defective.",
         .check = "Does the fault return? The restart tested the whole RAM.",
         .cure = "Replace the board if the fault returns.",
         .clear = NOTHING},
    [FAULT_HOLDING_BRAKE] =
        {.name = "holding brake",
         .owner = FAULT_OF_AXIS,
         .detection = "The brake's contact does not confirm the brake's output for 100 ms longer than the release time "
                      "2060:24 or the engage time 2060:25.",
         .when = "Always, if 2060:26 is 1.",
         .timer = "",
         .limits = LIMIT(24) | LIMIT(25) | LIMIT(26),
         .cause = "The brake sticks or is worn, its coil has no current, or a wire of coil or contact is broken.",
         .check = "Read 3061:1 with the axis enabled and with the axis off: it contains 4 while the brake of azimuth "
                  "is released, 8 while that of pitch is.",
         .cure = "Repair the brake or the wire. If the brake has no contact, set 2060:26 to 0.",
         .clear = RESET},
    [FAULT_SAFE_TORQUE_OFF] = {.name = "safe torque off",
                               .owner = FAULT_OF_AXIS,
                               .detection = "Both channels of STO have removed the torque.",
                               .when = "Always. The outputs are off before the program notices.",
                               .timer = "",
                               .cause =
                                   "The safety circuit of the machine is open: emergency stop, guard door, key switch.",
                               .check =
                                   "Read 3061:1: it contains 1 while channel A permits torque, 2 while channel B does.",
                               .cure = "Close the safety circuit.",
                               .clear = RESET},
    [FAULT_SAFE_TORQUE_FAULT] =
        {.name = "safe torque off: channels",
         .owner = FAULT_OF_AXIS,
         .detection = "One channel of STO has removed the torque for more than 100 ms and the other has not, or a "
                      "driver's enable contradicts its command for 3 ms.",
         .when = "Always. The outputs are off at once, whichever channel it was.",
         .timer = "",
         .cause = "A broken or shorted wire of one channel, or a defective input circuit or driver enable.",
         .check = "Read 3061:1: it contains 1 while channel A permits torque, 2 while channel B does. Measure both "
                  "channels at the terminals.",
         .cure = "Repair the channel. Then open and close both channels once.",
         .clear = RESET},
    [FAULT_CLOCK] = {.name = "clock",
                     .owner = FAULT_OF_AXIS,
                     .detection = "The system clock differs by more than 1.84 % from the chip's own 16 MHz oscillator.",
                     .when = "Always, on the board.",
                     .timer = "",
                     .cause =
                         "The crystal is damaged or is a wrong one. All speeds and times are wrong by the same factor.",
                     .check = "Measure the crystal's frequency: 24 MHz is right.",
                     .cure = "Replace the board.",
                     .clear = RESET},
    [FAULT_OPTION_BYTES] =
        {.name = "option bytes",
         .owner = FAULT_OF_BOARD,
         .reported_once = true,
         .detection =
             "An option byte of the chip is not as the program needs it. The detail is a sum: 1: the parity of the RAM "
             "is off, 2: the program is not write-protected, 4: the flash has one bank, or starts from the second "
             "one. With 4 both axes stay off, and nothing is stored.",
         .when = "At start-up.",
         .timer = "",
         .cause = "1, 2: the board was flashed without its option bytes, or with st-flash, which cannot write-protect "
                  "pages. 4: the chip was set to one bank or to start from the second one, and flashed without "
                  "tools/image/board, which refuses such a chip.",
         .check = "Read 3061:1: it contains 16 if the RAM parity is on, 32 if the program is write-protected, 64 if "
                  "the flash is read-protected, 128 if the flash has the right banks.",
         .cure =
             "1, 2: flash the board with OpenOCD, or set the option bytes with tools/image/board openocd protect. 4: "
             "tools/image/board openocd options, which erases the flash, then flash (docs/board.md).",
         .clear = NOTHING},
    [FAULT_PARAMETERS_LOST] =
        {.name = "stored parameters rejected",
         .owner = FAULT_OF_STORE,
         .detection =
             "The node did not load a stored parameter set that may be the newest, or a stored node id. The detail is "
             "a sum: 1 damaged or unreadable, 2 incomplete, 4 rejected by the checks, 8 COB-IDs that collide under the "
             "present node id (the communication objects then have their defaults), 16 node id or bit rate.",
         .when = "At start-up and after a reset. Both axes are then in fault, because gains and limits in effect may "
                 "be older than the stored ones. With detail 8 alone they are not.",
         .timer = "",
         .cause = "Power was lost while the set was being stored, the flash is worn, or the set "
                  "belongs to another firmware.",
         .check = "Read 3031:1, and compare the active values with a gains file (servoctl diff). With detail 16, read "
                  "node id and bit rate in 3050.",
         .cure = "Restore a known good gains file. With detail 16, store node id and bit rate again by LSS.",
         .clear = "Fault reset: you accept the values in effect. Then store them (servoctl store): the EMCY ends, and "
                  "the fault does not return."},
    [FAULT_MASTER_SILENT] =
        {.name = "master silent",
         .detection = "The axis turned, and the node received no frame for it during the time 3041:1: no NMT command, "
                      "SDO request, RPDO, SYNC of a synchronous PDO, or heartbeat of a node in 1016.",
         .when = "In operation, unless 6007 is 0. With 6007 = 2 or 3 it is a report, not a fault: the axis is switched "
                 "off, or stopped by a quick stop, and has the warning bit until it is enabled again.",
         .timer = "3041:1",
         .cause = "The master has ended, has lost the bus, or commands a motion and then only listens.",
         .check = "Are there frames for this node on the bus while the axis turns?",
         .cure = "Let the master send a frame to the node more often than every 3041:1; a heartbeat that 1016 lists is "
                 "best. To move an axis without supervision, set 6007 to 0.",
         .clear = "Fault reset (6007 = 1), or enable the axis again."},
    [FAULT_CAMERA_STALE] =
        {.name = "camera frames do not count",
         .owner = FAULT_OF_BOARD,
         .reported_once = false,
         .detection =
             "Six frames of the camera in a row did not count, or more than two in five; of frames that are sent "
             "again, eight in a row or more than half. The detail is the reason, 3072:4.",
         .when = "While an axis is in operation in mode -1.",
         .timer = "",
         .cause = "The image processor has frozen and repeats a picture or its counter, or restarts again and "
                  "again. Detail 7: the camera is mounted upside down, or its picture is turned or mirrored, or does "
                  "not answer the motion of the axes (3072:9). "
                  "Detail 5: 1013 is set again and again. Detail 8: 3071:1 does not fit the unit of the errors. Detail "
                  "9 or 10: it has lost its target, or takes turns between two. Detail 1 while the axes follow a "
                  "target: two image processors send with the same identifier.",
         .check =
             "Read 3072:4. Does 3070:5 advance by one with each frame, and do 3070:1 and 3070:2 change when the axes "
             "move? Detail 7: read 3072:9 and 3072:10.",
         .cure = "Restart the image processor. The axes coast for 2011:5, then stop; they follow the next frame that "
                 "counts. Detail 7: the axes stop at once; correct 3071:2 and 3071:7 (servoctl camera calibrate).",
         .clear = "No frame has been dropped for a second, or no axis tracks."},
    [FAULT_ACTIVE_SET] =
        {.name = "active values changed by themselves",
         .detection = "Gains, limits, motor data or scales in use differ from their complement copy, although nothing "
                      "was written. All of them are compared within 24 ms.",
         .when = ALWAYS,
         .timer = "",
         .cause = "A bit of the RAM has flipped, or an error in the firmware.",
         .check = "Has fault 36 (RAM) been logged too? Does it return?",
         .cure = "Reset the node: the stored values are loaded again. Replace the board if it returns.",
         .clear = "Reset of the node (NMT 81), or writing the set again, then fault reset."},
};
