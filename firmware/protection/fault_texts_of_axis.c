/* SPDX-License-Identifier: Apache-2.0 */
/* Texts of the faults of an axis: sensors, current, voltage and heat, motion, loops. */
#include "protection/fault_phrases.h"

#define DRIVEN "While a control loop is closed."
#define SPEED_DRIVEN "While the speed loop is closed."

const fault_text fault_texts_of_axis[FAULT_COUNT] = {
    [FAULT_NONE] = {.name = "no fault"},
    [FAULT_ENCODER_LOST] =
        {.name = "encoder lost",
         .detection = "One tick without a valid reading: no answer, wrong CRC, or the encoder's error bit is set.",
         .when = ALWAYS,
         .timer = "",
         .cause = "Cable, connector or supply of the encoder, or dirt on its scale.",
         .check = "Measure the supply at the encoder while the axis turns. Check shield and termination of the line, "
                  "and whether the fault always occurs at the same position.",
         .cure = "Replace the cable, clean the scale, or replace the encoder.",
         .clear = RESET},
    [FAULT_ENCODER_JUMP] =
        {.name = "encoder jump",
         .detection = "Position increment changed by more than 2060:4 between consecutive ticks.",
         .when = ALWAYS,
         .timer = "",
         .limits = LIMIT(4),
         .cause = "Interference on the line that passes the CRC by chance, a loose scale, or an acceleration above "
                  "what 2060:4 permits.",
         .check = "joint_angle and joint_rate in the fault log: a single step, or noise over many ticks?",
         .cure = "Fasten the scale and shield the line. Raise 2060:4 only if the axis can really accelerate that fast.",
         .clear = RESET},
    [FAULT_ENCODER_STUCK] = {.name = "encoder stuck",
                             .detection = "Identical readings for the time 2060:5. A working encoder shows noise.",
                             .when = ALWAYS,
                             .timer = "2060:5",
                             .limits = LIMIT(5),
                             .cause = "The encoder repeats its last word, or its resolution is too low to show noise.",
                             .check = "Does 6064 change while you turn the axis by hand?",
                             .cure =
                                 "Replace the encoder. If its resolution is too low to show noise, set 2060:5 to 0.",
                             .clear = RESET},
    [FAULT_SENSORS_DISAGREE] =
        {.name = "encoder and gyro disagree",
         .detection = "Encoder and gyro rates, filtered over 3 ms, differ by more than 2060:2 plus 2 % of the joint "
                      "rate for 5 ticks. On a moving base (2060:27 = 0) with gyros on the line of sight, 2060:2 counts "
                      "1/cos(pitch) times for the azimuth.",
         .when = "Always. A wrong sign or scale shows only while the axis or its base turns.",
         .timer = "",
         .limits = LIMIT(2),
         .cause = "One of the two sensors is loose, frozen, or has the wrong sign or scale, or the base turns faster "
                  "than 2060:2.",
         .check = "With the base at rest, compare gyro and joint_rate in the fault log: sign, scale, and which of them "
                  "does not change.",
         .cure = "Correct the mounting or the wiring. Raise 2060:2 only if the base is allowed to turn that fast.",
         .clear = RESET},
    [FAULT_GYRO_LOST] =
        {.name = "gyro lost",
         .detection = "No valid gyro rate for 5 ticks while the speed loop uses the gyro.",
         .when = "Always, unless the rate source 2050:1 is the encoder alone.",
         .timer = "",
         .cause = "Cable, supply or start-up of the gyro, or the gyro reports an internal fault.",
         .check = "Measure the gyro's supply current and check that it sends frames.",
         .cure = "Repair the cable or replace the gyro. Until then the axis can run on the encoder: set 2050:1 to 0.",
         .clear = RESET},
    [FAULT_GYRO_STUCK] = {.name = "gyro stuck",
                          .detection = "Identical gyro rates for the time 2060:5. A working gyro shows noise.",
                          .when = ALWAYS,
                          .timer = "2060:5",
                          .limits = LIMIT(5),
                          .cause = "The gyro repeats its last frame, or its resolution is too low to show noise.",
                          .check = "Does gyro in the fault log change while the axis turns?",
                          .cure = "Replace the gyro. If its resolution is too low to show noise, set 2060:5 to 0.",
                          .clear = RESET},
    [FAULT_GYRO_SATURATED] =
        {.name = "gyro saturated",
         .detection = "Gyro rate at 99 % of its range 2060:3 or more for 2 ticks.",
         .when = ALWAYS,
         .timer = "",
         .limits = LIMIT(3),
         .cause = "The axis or its base turned faster than the gyro can measure, or the gyro failed.",
         .check = "Compare joint_rate with gyro in the fault log, and 2060:3 with the gyro's data sheet.",
         .cure = "Lower 607F and 2060:1. Replace the gyro if the fault occurs at rest.",
         .clear = RESET},
    [FAULT_IMPLAUSIBLE] = {.name = "implausible sample",
                           .detection = "A sample is not finite or exceeds 1000 rad/s.",
                           .when = ALWAYS,
                           .timer = "",
                           .cause = "A sensor sends such values, or the firmware has an error.",
                           .check = "Which signal in the fault log is not a number?",
                           .cure =
                               "Replace that sensor. If no sensor is at fault, report the fault with its fault log.",
                           .clear = RESET},
    [FAULT_CURRENT_OFFSET] =
        {.name = "current while bridge is off",
         .detection = "The current, filtered over 10 ms, exceeds 2060:13 for 10 ticks.",
         .when = "While the bridge is off, from 20 ms after it was switched off.",
         .timer = "",
         .limits = LIMIT(13),
         .cause = "The zero of the current sensor has drifted, or the bridge conducts although it is off.",
         .check = "current in the fault log: does it remain with the motor disconnected?",
         .cure = "Restart the board to measure the zero again. If the fault returns, replace the current amplifier or "
                 "the bridge.",
         .clear = RESET},
    [FAULT_CURRENT_SENSOR] =
        {.name = "current and voltage disagree",
         .detection = "Bridge voltage minus L di/dt, R i and Ke w exceeds 2060:14, plus 40 % of R i for a warm winding "
                      "or 2060:22 of R i for one of less resistance. Each such tick counts up, any other tick counts "
                      "down; the limit is 8.",
         .when = DRIVEN,
         .timer = "",
         .limits = LIMIT(14) | LIMIT(22),
         .cause = "The current sensor is dead or has an offset, a motor lead is off or swapped, or 2055 does not match "
                  "this motor.",
         .check = "current and torque in the fault log, the winding resistance at the plug, and 2055:2 and 2055:4.",
         .cure = "Repair the wiring or the sensor. Set 2055 to the motor's data.",
         .clear = RESET},
    [FAULT_OVER_CURRENT_TRIP] = {.name = "over-current trip",
                                 .detection = "The bridge's hardware comparator has switched the bridge off.",
                                 .when = ALWAYS,
                                 .timer = "",
                                 .cause = "Short circuit in the winding or the cable, or a failed transistor.",
                                 .check =
                                     "Measure the resistance between the motor leads, and from each lead to earth.",
                                 .cure = "Replace the shorted part before you switch on again.",
                                 .clear = RESET},
    [FAULT_OVER_CURRENT] =
        {.name = "over-current",
         .detection = "Mean current of a tick exceeds 1.3 times the current limit 2055:6 for 2 ticks.",
         .when = ALWAYS,
         .timer = "",
         .cause = "Current loop too fast for this motor, failed current sensor, or shorted turns in the winding.",
         .check = "current in the fault log: does it oscillate or stay constant? Check 2055:2, 2055:3 and 2055:5.",
         .cure = "Set 2055 to the motor's data and lower the bandwidth 2055:5.",
         .clear = RESET},
    [FAULT_OVERLOAD] =
        {.name = "motor overload",
         .detection =
             "Mean square current, averaged with the time constant 2060:12, exceeds the square "
             "of 2060:11. A bridge that is off heats nothing, and a reading beyond 130 % of "
             "the current limit counts as 130 %. A warning (statusword bit 7) is given from 90 % of this current.",
         .when = ALWAYS,
         .timer = "",
         .limits = LIMIT(11) | LIMIT(12),
         .cause = "Friction, unbalance or wind needs more current than the motor can carry continuously.",
         .check = "Read the torque 6077: at rest it shows unbalance, at constant speed friction.",
         .cure = "Balance the axis, lower the accelerations, and wait until the winding has cooled.",
         .clear = "Fault reset after the winding has cooled (about twice the time 2060:12)."},
    [FAULT_UNDER_VOLTAGE] = {.name = "bus under-voltage",
                             .detection = "Bus voltage below 2060:15 for 5 ticks.",
                             .when = DRIVEN,
                             .timer = "",
                             .limits = LIMIT(15),
                             .cause = "The supply is off or too weak, or its cable is too thin.",
                             .check = "Compare bus_voltage with torque in the fault log.",
                             .cure = "Use a stronger supply or a thicker cable, or lower the accelerations.",
                             .clear = RESET},
    [FAULT_OVER_VOLTAGE] = {.name = "bus over-voltage",
                            .detection = "Bus voltage above 2060:16 for 2 ticks.",
                            .when = ALWAYS,
                            .timer = "",
                            .limits = LIMIT(16),
                            .cause = "Braking feeds energy back into a supply that cannot absorb it.",
                            .check = "Compare bus_voltage with joint_rate in the fault log.",
                            .cure = "Lower 6084 and 6085, or add a brake chopper or more capacitance.",
                            .clear = RESET},
    [FAULT_POWER_STAGE] = {.name = "power stage fault",
                           .detection = "The bridge's driver reports a fault, or the wire of its fault pin is broken.",
                           .when = ALWAYS,
                           .timer = "",
                           .cause =
                               "The driver has no supply, is too hot or is dead, or the wire of its fault pin is off.",
                           .check = "Measure the driver's supply and its fault pin.",
                           .cure = "Repair the wire or replace the driver.",
                           .clear = RESET},
    [FAULT_OVER_TEMPERATURE] = {.name = "heat sink over-temperature",
                                .detection = "Heat sink above 85 degrees C.",
                                .when = ALWAYS,
                                .timer = "",
                                .cause = "The load is too high, the sun heats the housing, or the cooling is too weak.",
                                .check = "Measure the temperature of the heat sink. Check fan and air flow.",
                                .cure = "Let it cool and improve the cooling.",
                                .clear = RESET},
    [FAULT_OVER_SPEED] =
        {.name = "over-speed",
         .detection = "Joint rate exceeds 2060:1 for 2 ticks.",
         .when = ALWAYS,
         .timer = "",
         .limits = LIMIT(1),
         .cause = "Axis driven externally (wind, by hand), or unstable gains. Set-points cannot exceed 88 % of 2060:1.",
         .check = "reference, rate and torque in the fault log: did the set-point demand this speed?",
         .cure = "Lower 607F or correct the gains. Raise 2060:1 only as far as the machine allows.",
         .clear = RESET},
    [FAULT_RUNAWAY] =
        {.name = "runaway",
         .detection =
             "For 24 ticks more than half of the torque limit acts towards the set-point, the rate differs from it by "
             "more than a tenth of 2060:6, and the axis turns away from it, ever faster, or its rate falls by more "
             "than 0.055 s times 2060:19 (and 2 ms more for each angle of 2050:3 beyond two). Or its path against the "
             "sign of the set-point, while it accelerates that way, exceeds 2060:31 although more than a quarter of "
             "the "
             "motor's torque has acted towards the set-point for 28 ms without a break.",
         .when = SPEED_DRIVEN,
         .timer = "",
         .limits = LIMIT(6) | LIMIT(19) | LIMIT(31),
         .cause = "Motor leads swapped, a sensor with the wrong sign, or an external load stronger than the motor.",
         .check = "Compare the signs of torque, current and joint_rate in the fault log.",
         .cure = "Swap the motor leads or correct the sensor's sign. Do not switch on again before that.",
         .clear = RESET},
    [FAULT_BEYOND_TRAVEL] =
        {.name = "travel limit exceeded",
         .detection = "The position is outside 2060:9 to 2060:10 and has moved further outwards by 2 mrad.",
         .when = "While a control loop is closed, if 2060:9 is less than 2060:10.",
         .timer = "",
         .limits = LIMIT(9) | LIMIT(10),
         .cause =
             "Axis driven externally (wind, by hand), overshoot larger than 2060:17, or the zero position has moved.",
         .check = "Compare 6064 with 2060:9 and 2060:10.",
         .cure = "Command a motion inwards: the drive permits it. Then set the software limits 607D further inside.",
         .clear = RESET},
    [FAULT_STALL] = {.name = "stall",
                     .detection = "Slower than 0.002 rad/s with the torque at its limit for the time 2060:8.",
                     .when = SPEED_DRIVEN,
                     .timer = "2060:8",
                     .limits = LIMIT(8),
                     .cause =
                         "The axis is blocked, locked or frozen, or its torque limit is below the break-away torque.",
                     .check = "Turn the axis by hand. Compare 6072, 60E0 and 60E1 with the break-away torque in 2030.",
                     .cure = "Free the axis, release its lock, or raise the torque limit.",
                     .clear = RESET},
    [FAULT_SPEED_ERROR] =
        {.name = "speed error",
         .detection =
             "Set-point minus rate exceeds 2060:6 for the time 2060:7. Or its path against the sign of the "
             "set-point, while it accelerates that way and its torque does not push it there, exceeds 2060:31.",
         .when = SPEED_DRIVEN,
         .timer = "2060:7",
         .limits = LIMIT(6) | LIMIT(7) | LIMIT(31),
         .cause = "Acceleration not reachable within the torque limit, excessive load, or oscillating gains. With a "
                  "torque limit below a quarter of the motor's torque also swapped motor leads or a sensor with the "
                  "wrong sign.",
         .check = "reference, rate and torque in the fault log: is the torque at its limit?",
         .cure = "Lower 6083 and 6084, reduce the load, or correct the gains.",
         .clear = RESET},
    [FAULT_FOLLOWING_ERROR] =
        {.name = "following error",
         .detection = "Position error exceeds 6065 for longer than 6066, or exceeds a quarter turn.",
         .when = "While the position loop is closed.",
         .timer = "6066",
         .cause = "Set-points move faster than the axis can follow.",
         .check = "Read the following error 60F4 during the motion. Check the torque limit, the load and the gains.",
         .cure = "Use slower set-points. Widen 6065 if the motion profile is right.",
         .clear = RESET},
    [FAULT_MOTOR_CONTRADICTS] =
        {.name = "motor contradicts encoder and gyro",
         .detection = "The motor's voltage does not follow from its current and from the speed that the sensors show, "
                      "whatever resistance and back-EMF constant 2060:22 permits and the motor has shown before. The "
                      "difference, filtered over 5 ms, exceeds for 5 ticks the sum of 2060:23, 4 % of the back-EMF, "
                      "the share 2060:22 of L di/dt, and the back-EMF of 1 ms of acceleration.",
         .when = DRIVEN,
         .timer = "",
         .limits = LIMIT(22) | LIMIT(23),
         .cause = "Encoder and gyro are wrong in the same way (frozen, wrong scale), the coupling between motor and "
                  "encoder slips, 2055:4 is too small, or the current sensor is wrong.",
         .check = "With the axis off, turn it by hand by a known angle: do 6064 and the sum of the gyro rate show this "
                  "angle? Compare 2055:2 and 2055:4 with the data sheet of the motor.",
         .cure = "Repair the sensor or the coupling, or correct 2055. Raise 2060:23 only for a bridge with more dead "
                 "time.",
         .clear = RESET},
    [FAULT_MOTOR_WEAK] =
        {.name = "motor constant too small",
         .detection = "The motor gives less back-EMF for the speed of encoder and gyro than 2055:4 and 2060:22 permit. "
                      "Its torque is too small by the same factor.",
         .when = "While a control loop is closed and the axis turns fast enough that the difference exceeds 2060:23.",
         .timer = "",
         .limits = LIMIT(22) | LIMIT(23),
         .cause = "2055:1 and 2055:4 are not those of this motor, heat has weakened its magnets, or encoder and gyro "
                  "both show too much.",
         .check = "Compare 2055:1 and 2055:4 with the data sheet of the motor; identify the axis again.",
         .cure = "Correct 2055, or replace the motor.",
         .clear = RESET},
    [FAULT_OSCILLATION] =
        {.name = "oscillation",
         .detection = "The motor itself sustains an oscillation: several swings of the speed error in a row that no "
                      "set-point and no external torque explains, or swings of the torque faster than 25 Hz.",
         .when = "While the speed, position or tracking loop is closed, and the gains that ran before cannot be taken "
                 "back or oscillate too.",
         .timer = "",
         .cause =
             "The gains do not fit the axis: too high, too much filtering, or the load has changed. In mode -1 also "
             "the camera: a wrong sign or age of its frames, errors that jump, or a boresight (3071:3, :4) that is "
             "written while it tracks. Less often: a loose coupling, or a base that gives way.",
         .check = "Read the period of the oscillation from rate and torque in the fault log. Compare 2056 with the "
                  "load and the inertia that the axis has now. After mode -1 compare 3070 with the target, and the "
                  "stated age with 3073:5.",
         .cure =
             "After mode -1: mend sign, age and filter of the image processor first. Else restore a gains file that "
             "worked, or identify and tune again (servoctl tune). Lower 2000:1 and 2020:4 if the load has changed.",
         .clear = RESET},
    [FAULT_GAINS_TAKEN_BACK] =
        {.name = "gains taken back",
         .reported_once = true,
         .detection = "The axis began to oscillate with a newly applied parameter set. The set that ran before without "
                      "oscillation is active again; the axis stays in operation.",
         .when = "While the speed, position or tracking loop is closed.",
         .timer = "",
         .cause = "Somebody applied an unstable set in spite of the check against the identified plant (2056), or 2056 "
                  "does not describe this axis. In mode -1 also the camera: a wrong sign or age of its frames.",
         .check = "Compare the CRC of the active set, 2070:4, with that of the set that you applied. If 2056 is not of "
                  "this axis, identify it again. After mode -1 compare the stated age with 3073:5.",
         .cure = "Lower the gain that the check named in 2070:6, or tune again (servoctl tune).",
         .clear = NOTHING},
    [FAULT_SENSORS_DRIFT] =
        {.name = "encoder and gyro disagree (drift)",
         .detection = "The angles of encoder and gyro have drifted apart by more than 2060:27 plus 0.5 % of the path, "
                      "with a memory of 5 s. Which of the two is wrong cannot be decided.",
         .when = "Always, unless 2060:27 is 0: then the base moves. The envelope then bounds what a drift of the gyro "
                 "does, and nothing bounds a creep of the encoder.",
         .timer = "",
         .limits = LIMIT(27),
         .cause = "The gyro has a bias, the encoder or its coupling creeps, or the base turns.",
         .check = "With the axis off and the base at rest, compare gyro and joint_rate in the fault log.",
         .cure = "Replace the sensor that shows a rate. Set 2060:27 to 0 only if the base really moves.",
         .clear = RESET},
    [FAULT_ENCODER_ERRATIC] =
        {.name = "encoder erratic",
         .detection = "Single increments of the encoder differ from the gyro by more than 2060:28 in more than 5 % of "
                      "the ticks, at least four times within 60 ms.",
         .when = "Always, with a gyro. A stale reading shows only while the axis turns.",
         .timer = "",
         .limits = LIMIT(28),
         .cause = "Readings are one tick old, a bit flips, the scale is dirty, or the line is disturbed.",
         .check = "joint_rate in the fault log: single ticks that differ while gyro does not change.",
         .cure = "Repair the line, clean the scale, or replace the encoder.",
         .clear = RESET},
    [FAULT_STANDSTILL_LEFT] =
        {.name = "standstill left",
         .detection = "An axis that is commanded to stand moved by more than 2060:29, from 1 s after its last command "
                      "on. A creep below 0.1 mrad/s does not count.",
         .when = "While a control loop is closed with set-point 0 or an unchanged position, no experiment runs, and "
                 "2060:27 declares the base fixed.",
         .timer = "",
         .limits = LIMIT(29) | LIMIT(27),
         .cause = "A gyro bias, gains too small to hold the axis, a torque offset (60B2), or a load beyond the torque.",
         .check = "6064 before and after; 2000:1, 2000:2 and 60B2.",
         .cure = "Remove the cause. Raise 2060:29 only if the axis may move that far.",
         .clear = RESET},
    [FAULT_NO_ANSWER] =
        {.name = "no answer to the test torque",
         .detection = "A torque of at most 2 % of the motor's swings a standing axis at 42 Hz, and its rate swings by "
                      "less than 2060:32, half of the least that inertia, friction and gains permit, for two windows "
                      "of 192 ms.",
         .when = "While a control loop is closed with set-point 0 or an unchanged position and uses a gyro that turns "
                 "with the axis, no experiment runs, the torque is not limited below a tenth of the motor's, and "
                 "2060:21 is not 2 (commissioning).",
         .timer = "",
         .limits = LIMIT(32),
         .cause = "Encoder and gyro are dead together, the axis is blocked (transport lock, holding brake), the motor "
                  "does not drive it, or the axis has far more inertia than 2056:1 says.",
         .check = "Do 6064 and gyro in the fault log change while you turn the axis by hand? Is it free to turn?",
         .cure = "Replace the sensors, or release the axis. Set 2060:32 to 0 only if nothing may swing the axis.",
         .clear = RESET},
    [FAULT_REDUCED_SPEED] = {.name = "reduced speed exceeded",
                             .detection = "Mean joint rate of 4 ms above 2060:30 while 2062 is 1.",
                             .when = "While a control loop is closed, from 1 s after 2062 was set.",
                             .timer = "",
                             .limits = LIMIT(30),
                             .cause =
                                 "A set-point above the limit, or a set-point that was not reduced when 2062 was set.",
                             .check = "reference and joint_rate in the fault log.",
                             .cure = "Reduce the set-point before you set 2062.",
                             .clear = RESET},
    [FAULT_TOO_FAST] =
        {.name = "too fast towards the end of the travel",
         .detection =
             "The joint rate is above what 2060:19 can still stop before 2060:9 or 2060:10. While 2061:1 is not 0, "
             "or 2060:21 is 2: the rate is above 5 deg/s.",
         .when = "While the axis has power, and while it turns since it had power.",
         .timer = "",
         .limits = LIMIT(9) | LIMIT(10) | LIMIT(19) | LIMIT(21),
         .cause =
             "Ramps, gains or torque limits with which the drive cannot stop, an external torque, or a 2060:19 that "
             "is larger than what the machine has.",
         .check = "2061:6 and 2061:7, and reference, rate and torque in the fault log: did the drive try to brake?",
         .cure = "Correct 6084, 60A4, 6072 and the gains. Measure 2060:19 again if the machine has changed.",
         .clear = RESET},
    [FAULT_STOP_IGNORED] =
        {.name = "stop not followed",
         .detection =
             "0.5 s after a fault or a stop command the axis has not slowed down by half of 2060:20, or before that "
             "it was more than 0.1 rad/s faster than at the beginning and than its set-point.",
         .when = "During a stop that a fault or a command ordered, until the axis is at rest.",
         .timer = "",
         .limits = LIMIT(20),
         .cause =
             "Gains or torque limits with which the speed loop cannot stop the axis, 605E = 0, or an external torque.",
         .check = "reference, rate and torque in the fault log: does the torque oppose the motion?",
         .cure = "Correct the gains and 6072, 60E0, 60E1, or reduce the load.",
         .clear = RESET},
    [FAULT_BRAKING_FAILS] =
        {.name = "protective stop not followed",
         .detection = "The torque of the protective stop does not slow the axis down by half of 2060:19.",
         .when = "During a protective stop.",
         .timer = "",
         .limits = LIMIT(19),
         .cause = "A motor lead is off or swapped, the supply is too weak, or an external torque exceeds the motor's.",
         .check = "current and torque in the fault log: does the current follow?",
         .cure = "Repair the wiring. Measure 2060:19 again.",
         .clear = RESET},
};
