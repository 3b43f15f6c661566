"""Which tables of each study the pages quote."""

# In the order in which they are published: the longest last.
TABLES = {
    "paper": ("tables/table_1_memory.csv", "tables/table_2_times.csv", "tables/table_3_frame_times.csv",
              "tables/table_4_depths.csv", "tables/table_5_pairs.csv",  # from 3 on: of scenes of several muscles
              "tables/smoothness.csv"),
    "speed": ("speed.csv",),
    "hard": ("tables/cells.csv", "tables/cases.csv"),
    "budget": ("tables/budget.csv", "tables/substeps.csv"),
    "moment-arms": ("tables/moment_arms.csv",),
    "effects": ("tables/effect_costs.csv", "tables/effect_changes.csv", "tables/effect_prices.csv",
                "tables/returns.csv", "tables/guards.csv"),
    "accuracy": ("tables/price_list.csv", "tables/arm_price_list.csv", "tables/arm_errors.csv", "tables/force_errors.csv",
                 "tables/*_factors.csv", "tables/coupled_outcomes.csv", "tables/contact_difficulties.csv", "figures/offset_and_depth.csv", "study.csv"),
}
