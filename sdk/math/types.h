// SPDX-License-Identifier: Apache-2.0
// GLM types under our names. World: metres, right-handed, +Y up. Quaternions are xyzw in memory. Matrices are column-major.
#pragma once

#define GLM_FORCE_SILENT_WARNINGS
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace dpl {

template <class T>
using Vec2 = glm::vec<2, T, glm::defaultp>;
template <class T>
using Vec3 = glm::vec<3, T, glm::defaultp>;
template <class T>
using Vec4 = glm::vec<4, T, glm::defaultp>;
template <class T>
using Mat2 = glm::mat<2, 2, T, glm::defaultp>;
template <class T>
using Mat3 = glm::mat<3, 3, T, glm::defaultp>;
template <class T>
using Mat4 = glm::mat<4, 4, T, glm::defaultp>;
template <class T>
using Mat3x4 = glm::mat<4, 3, T, glm::defaultp>;  // 3 rows, 4 columns: a rigid or affine transform [R | t]
template <class T>
using Quat = glm::qua<T, glm::defaultp>;

using Vec2f = Vec2<float>;
using Vec3f = Vec3<float>;
using Vec4f = Vec4<float>;
using Mat3f = Mat3<float>;
using Mat4f = Mat4<float>;
using Mat3x4f = Mat3x4<float>;
using Quatf = Quat<float>;
using Vec2d = Vec2<double>;
using Vec3d = Vec3<double>;
using Vec4d = Vec4<double>;
using Mat3d = Mat3<double>;
using Mat4d = Mat4<double>;
using Mat3x4d = Mat3x4<double>;
using Quatd = Quat<double>;
using Triangle = glm::uvec3;  // three vertex indices, counter-clockwise seen from outside

}  // namespace dpl
