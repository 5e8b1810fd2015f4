// SPDX-License-Identifier: Apache-2.0
// Unit quaternions, (x, y, z, w).
vec4 dplQuaternionOf(mat3 m) {
    vec4 q;
    if (m[0][0] + m[1][1] + m[2][2] > 0.0) q = vec4(m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0], 1.0 + m[0][0] + m[1][1] + m[2][2]);
    else if (m[0][0] > m[1][1] && m[0][0] > m[2][2]) q = vec4(1.0 + m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[2][0] + m[0][2], m[1][2] - m[2][1]);
    else if (m[1][1] > m[2][2]) q = vec4(m[0][1] + m[1][0], 1.0 + m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1], m[2][0] - m[0][2]);
    else q = vec4(m[2][0] + m[0][2], m[1][2] + m[2][1], 1.0 + m[2][2] - m[0][0] - m[1][1], m[0][1] - m[1][0]);
    return q * inversesqrt(dot(q, q));
}

/** The rotation by a, after that by b. */
vec4 dplQuaternionProduct(vec4 a, vec4 b) { return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz)); }

mat3 dplRotationOf(vec4 q) {
    vec3 x = vec3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.z * q.w), 2.0 * (q.x * q.z - q.y * q.w));
    vec3 y = vec3(2.0 * (q.x * q.y - q.z * q.w), 1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z + q.x * q.w));
    return mat3(x, y, cross(x, y));
}
