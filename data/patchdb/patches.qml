<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology|MapTips">
 <renderer-v2 type="categorizedSymbol" attr="state" symbollevels="0" enableorderby="0" forceraster="0">
  <categories>
   <category symbol="0" value="active" label="active" render="true"/>
   <category symbol="1" value="retired" label="retired" render="true"/>
  </categories>
  <symbols>
   <symbol type="marker" name="0" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="name" value="circle"/>
      <Option type="QString" name="color" value="31,98,173,255"/>
      <Option type="QString" name="outline_color" value="31,98,173,255"/>
      <Option type="QString" name="size" value="1.6"/>
      <Option type="QString" name="size_unit" value="MM"/>
     </Option>
    </layer>
   </symbol>
   <symbol type="marker" name="1" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="name" value="cross2"/>
      <Option type="QString" name="color" value="141,151,163,255"/>
      <Option type="QString" name="outline_color" value="141,151,163,255"/>
      <Option type="QString" name="size" value="1.6"/>
      <Option type="QString" name="size_unit" value="MM"/>
     </Option>
    </layer>
   </symbol>
  </symbols>
 </renderer-v2>
 <mapTip>&lt;b&gt;[% "id" %]&lt;/b&gt; [% "state" %] [% coalesce("retired_reason", '') %]&lt;br&gt;quality [% coalesce(round("quality", 2), 'unknown') %], seen in [% "views" %] source(s), chip pixel [% round("gsd_m", 2) %] m&lt;br&gt;attempts: [% round("success_weight", 1) %] successful, [% round("failure_weight", 1) %] failed (weighted)</mapTip>
</qgis>
