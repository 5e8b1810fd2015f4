// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics up to degree 3 in the order and sign of 3D Gaussian splatting files (docs/reference/spherical-harmonics.md).
// d: unit direction from the eye to the splat, in the rest frame. Band 0 is the constant kShC0.

struct ShBand1 {  // coefficients 1 to 3
    real b1;
    real b2;
    real b3;
};

DPL_FN ShBand1 shBand1(real3 d) {
    ShBand1 b;
    b.b1 = real(-kShC1) * d.y;
    b.b2 = real(kShC1) * d.z;
    b.b3 = real(-kShC1) * d.x;
    return b;
}

struct ShBand2 {  // coefficients 4 to 8
    real b4;
    real b5;
    real b6;
    real b7;
    real b8;
};

DPL_FN ShBand2 shBand2(real3 d) {
    ShBand2 b;
    real xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z;
    b.b4 = real(1.0925484305920792) * (d.x * d.y);
    b.b5 = real(-1.0925484305920792) * (d.y * d.z);
    b.b6 = real(0.31539156525252005) * (zz + zz - xx - yy);
    b.b7 = real(-1.0925484305920792) * (d.x * d.z);
    b.b8 = real(0.5462742152960396) * (xx - yy);
    return b;
}

struct ShBand3 {  // coefficients 9 to 15
    real b9;
    real b10;
    real b11;
    real b12;
    real b13;
    real b14;
    real b15;
};

DPL_FN ShBand3 shBand3(real3 d) {
    ShBand3 b;
    real xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z, fourZz = real(4) * zz - xx - yy;
    b.b9 = real(-0.5900435899266435) * d.y * (real(3) * xx - yy);
    b.b10 = real(2.890611442640554) * (d.x * d.y) * d.z;
    b.b11 = real(-0.4570457994644658) * d.y * fourZz;
    b.b12 = real(0.3731763325901154) * d.z * (zz + zz - real(3) * xx - real(3) * yy);
    b.b13 = real(-0.4570457994644658) * d.x * fourZz;
    b.b14 = real(1.445305721320277) * d.z * (xx - yy);
    b.b15 = real(-0.5900435899266435) * d.x * (xx - real(3) * yy);
    return b;
}
