// A register of `reflect` in RTL, in lockstep with the model behind DPI-C: no files of vectors.
//
//     $ cargo build --release -p tapline-dpi
//     $ tapline vectors header reflect > tapline_reflect_pkg.sv
//     $ verilator --binary -Wall ../include/tapline_dpi_pkg.sv tapline_reflect_pkg.sv n_dot_v.sv n_dot_v_dpi_tb.sv \
//           --top-module n_dot_v_dpi_tb -LDFLAGS "-L$PWD/../../target/release -ltapline_dpi"
//     $ LD_LIBRARY_PATH=../../target/release obj_dir/Vn_dot_v_dpi_tb +cases=1000000

/* verilator lint_off LITENDIAN */
module n_dot_v_dpi_tb;
  import tapline_dpi_pkg::*;
  import tapline_reflect_pkg::*;

  // Numbers in and out lie in the order of the package's fields: v, the powers of v and n, n_mod; n, its fraction
  // bits, n_dot_v, n_dot_n, v_r, its fraction bits, the flags.
  localparam int FirstNmod = 5;
  localparam int NdotV = 4;
  localparam int Flags = 10;

  chandle model;
  int cases = 1000;
  int wrong = 0;
  logic signed [0:2][REFLECT_IN_V_BITS-1:0] n, v, next_n, next_v;
  logic signed [REFLECT_OUT_N_DOT_V_BITS-1:0] q;
  logic over;

  n_dot_v dut (.n, .v, .q, .over);

  // A number of so many bits with its sign, never the lowest: mantissas are symmetric. A third of them is extreme, and
  // a third is a power of two, whose products make ties.
  function automatic longint number(int bits);
    longint most = (64'sd1 <<< (bits - 1)) - 1;
    longint any = longint'({$urandom, $urandom}) >>> (64 - bits);
    case ($urandom_range(5))
      0: return most;
      1: return -most;
      2, 3: return 64'sd1 <<< $urandom_range(bits - 2);
      default: return any < -most ? -most : any;
    endcase
  endfunction

  initial begin
    void'($value$plusargs("cases=%d", cases));
    model = tapline_open("reflect", "", 0, 8);
    if (tapline_inputs(model) == 0) $fatal(1, "%s", tapline_error());
    for (int k = 0; k < cases; k++) begin
      for (int i = 0; i < 3; i++) begin
        tapline_set(model, FirstNmod + i, number(REFLECT_IN_N_MOD_BITS));
        next_v[i] = REFLECT_IN_V_BITS'(number(REFLECT_IN_V_BITS));
        tapline_set(model, i, 64'(signed'(next_v[i])));
      end
      if (tapline_eval(model) != 0) $fatal(1, "%s", tapline_error());
      for (int i = 0; i < 3; i++) next_n[i] = REFLECT_IN_V_BITS'(tapline_get(model, i));
      v = next_v;
      n = next_n;
      #1;
      if (64'(q) != tapline_get(model, NdotV) || 64'(over) != (tapline_get(model, Flags) >> REFLECT_OUT_FLAGS_N_DOT_V & 1)) begin
        wrong++;
      end
    end
    tapline_close(model);
    $display("%0d cases, %0d wrong", cases, wrong);
    if (wrong != 0) $fatal(1, "the register differs from the model");
    $finish;
  end
endmodule
