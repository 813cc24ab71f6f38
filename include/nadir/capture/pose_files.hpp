// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Camera poses of other programs, for the images of a survey folder.
#pragma once

#include <filesystem>
#include <vector>

#include "nadir/capture/folder_source.hpp"
#include "nadir/core/given_poses.hpp"

namespace nadir::capture {

/// A TUM trajectory: lines "t tx ty tz qx qy qz qw", seconds, map_from_camera; lines that start
/// with # are comments. Each image takes the pose nearest in time, at most half the shortest
/// interval between poses away (but 1 ms of rounding is forgiven, and 20 ms the most).
/// Lengths are metres, unless a comment says "unscaled" as nadir's own trajectory.tum does. Its
/// frame is the survey's when the cameras look down in it, as nadir's and any with z up.
/// Throws InputError with file, line, fault and remedy when it is malformed or has no pose for any
/// of the images.
GivenPoses read_tum(const std::filesystem::path& file, const std::vector<ListedImage>& images);

/// images.txt of a COLMAP text model (https://colmap.github.io/format.html): pixels and 3D points
/// are not used. Images are matched by file name without folder and extension; in the model of a
/// pair those of a folder "right" are passed over. The frame is COLMAP's own, without scale.
/// Throws as read_tum.
GivenPoses read_colmap_poses(const std::filesystem::path& model,
                             const std::vector<ListedImage>& images);

}  // namespace nadir::capture
