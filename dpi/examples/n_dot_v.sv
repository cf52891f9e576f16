/* verilator lint_off LITENDIAN */
// <n, v> of mantissas with 22 fraction bits, rounded half to even to Q4.22 and saturated.
module n_dot_v
  import tapline_reflect_pkg::*;
(
  input  logic signed [0:2][REFLECT_IN_V_BITS-1:0] n,
  input  logic signed [0:2][REFLECT_IN_V_BITS-1:0] v,
  output logic signed [REFLECT_OUT_N_DOT_V_BITS-1:0] q,
  output logic over
);
  localparam int Shift = 2 * (REFLECT_IN_V_BITS - 2) - REFLECT_OUT_N_DOT_V_FRAC;
  localparam logic signed [63:0] Max = (64'sd1 <<< (REFLECT_OUT_N_DOT_V_BITS - 1)) - 1;

  function automatic logic signed [63:0] product(logic signed [REFLECT_IN_V_BITS-1:0] a, logic signed [REFLECT_IN_V_BITS-1:0] b);
    return 64'(a) * 64'(b);
  endfunction

  logic signed [63:0] sum, kept, rounded;
  logic [Shift-1:0] rest;
  logic up;

  assign sum = product(n[0], v[0]) + product(n[1], v[1]) + product(n[2], v[2]);
  assign kept = sum >>> Shift;
  assign rest = sum[Shift-1:0];
  assign up = rest[Shift-1] && (rest[Shift-2:0] != 0 || kept[0]);
  assign rounded = kept + (up ? 64'sd1 : 64'sd0);
  assign over = rounded > Max || rounded < -Max - 1;
  assign q = over ? (rounded < 0 ? REFLECT_OUT_N_DOT_V_BITS'(-Max - 1) : REFLECT_OUT_N_DOT_V_BITS'(Max)) : REFLECT_OUT_N_DOT_V_BITS'(rounded);
endmodule
