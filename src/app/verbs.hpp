// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What each verb does; the exit status is returned, InputError tells why it could not be done.
#pragma once

#include "options.hpp"

namespace nadir::app {

inline int run(const Answered& answered) { return answered.status; }
int run(const Run& live);
int run(const Doctor& doctor);
int run(const ShowToken& show_token);
int run(const Replay& replay);
int run(const Simulate& simulate);
int run(const Recover& recover);
int run(const CheckCalibration& check_calibration);
int run(const DumpConfig& dump);

}  // namespace nadir::app
