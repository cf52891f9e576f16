// A register of `reflect` in RTL, against vectors of the whole stage.
//
//     $ tapline vectors gen reflect --count 400 --format readmemh > reflect.hex
//     $ tapline vectors header reflect > tapline_reflect_pkg.sv
//     $ verilator --binary -Wall tapline_reflect_pkg.sv n_dot_v.sv n_dot_v_tb.sv --top-module n_dot_v_tb
//     $ obj_dir/Vn_dot_v_tb

/* verilator lint_off LITENDIAN */
module n_dot_v_tb;
  import tapline_reflect_pkg::*;
  localparam int Count = 400;

  logic [REFLECT_VECTOR_BITS-1:0] words[Count];
  reflect_vector_t vector;
  logic signed [0:2][REFLECT_IN_V_BITS-1:0] n, v;
  logic signed [REFLECT_OUT_N_DOT_V_BITS-1:0] q;
  logic over;
  int wrong = 0;

  for (genvar i = 0; i < 3; i++) begin : g_wires
    assign v[i] = vector.inputs.v[i][REFLECT_IN_V_BITS-1:0];
    assign n[i] = vector.outputs.n[i][REFLECT_IN_V_BITS-1:0];
  end

  n_dot_v dut (.n, .v, .q, .over);

  initial begin
    $readmemh("reflect.hex", words);
    for (int k = 0; k < Count; k++) begin
      vector = words[k];
      #1;
      if (q != signed'(vector.outputs.n_dot_v[REFLECT_OUT_N_DOT_V_BITS-1:0]) || over != vector.outputs.flags[REFLECT_OUT_FLAGS_N_DOT_V]) begin
        wrong++;
        $display("vector %0d: %h => %h expected %h", k, vector.inputs, q, vector.outputs.n_dot_v);
      end
    end
    $display("%0d vectors, %0d wrong", Count, wrong);
    if (wrong != 0) $fatal(1);
    $finish;
  end
endmodule
