# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
