// A register of `reflect` in RTL, against vectors of the whole stage.
//
//     $ tapline vectors gen reflect --count 400 --format readmemh > reflect.hex
//     $ tapline vectors header reflect > tapline_reflect_pkg.sv
//     $ verilator --binary -Wno-fatal tapline_reflect_pkg.sv n_dot_v_tb.sv --top-module n_dot_v_tb && obj_dir/Vn_dot_v_tb

// <n, v> of mantissas with 22 fraction bits, rounded half to even to Q4.22 and saturated.
module n_dot_v
  import tapline_reflect_pkg::*;
(
  input  logic signed [0:2][V_BITS-1:0] n,
  input  logic signed [0:2][V_BITS-1:0] v,
  output logic signed [N_DOT_V_BITS-1:0] q,
  output logic over
);
  localparam int Shift = 2 * (V_BITS - 2) - N_DOT_V_FRAC;
  localparam logic signed [63:0] Max = (64'sd1 <<< (N_DOT_V_BITS - 1)) - 1;

  function automatic logic signed [63:0] product(logic signed [V_BITS-1:0] a, logic signed [V_BITS-1:0] b);
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
  assign q = over ? (rounded < 0 ? N_DOT_V_BITS'(-Max - 1) : N_DOT_V_BITS'(Max)) : N_DOT_V_BITS'(rounded);
endmodule

module n_dot_v_tb;
  import tapline_reflect_pkg::*;
  localparam int Count = 400;

  logic [VECTOR_BITS-1:0] words[Count];
  reflect_vector_t vector;
  logic signed [0:2][V_BITS-1:0] n, v;
  logic signed [N_DOT_V_BITS-1:0] q;
  logic over;
  int wrong = 0;

  for (genvar i = 0; i < 3; i++) begin : g_wires
    assign v[i] = vector.inputs.v[i][V_BITS-1:0];
    assign n[i] = vector.outputs.n[i][V_BITS-1:0];
  end

  n_dot_v dut (.n, .v, .q, .over);

  initial begin
    $readmemh("reflect.hex", words);
    for (int k = 0; k < Count; k++) begin
      vector = words[k];
      #1;
      // Bit 1 of the flags is n_dot_v's.
      if (q != signed'(vector.outputs.n_dot_v[N_DOT_V_BITS-1:0]) || over != vector.outputs.flags[1]) begin
        wrong++;
        $display("vector %0d: %h => %h expected %h", k, vector.inputs, q, vector.outputs.n_dot_v);
      end
    end
    $display("%0d vectors, %0d wrong", Count, wrong);
    if (wrong != 0) $fatal(1);
    $finish;
  end
endmodule
